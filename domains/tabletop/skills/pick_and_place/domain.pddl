; An object is taken from the table or from what it stands on, and put down on either.
(define (domain pick-and-place)
  (:predicates
    (Placeable ?o ?s) (Stackable ?o ?s) (Insertable ?o ?s))

  (:action pick
    :parameters (?o ?p ?g ?a ?l ?h)
    :precondition (and (Handling ?o ?p ?g ?a ?l ?h) (OnTable ?o ?p)
                       (not (Slidable ?o ?p)) (not (Topplable ?o ?p))
                       (AtPose ?o ?p) (HandEmpty) (AtConf ?a)
                       (not (Covered ?o)) (not (UnsafeHandling ?o ?h)))
    :effect (and (AtGrasp ?o ?g) (AtConf ?l)
                 (not (AtPose ?o ?p)) (not (HandEmpty)) (not (AtConf ?a))))

  (:action unstack
    :parameters (?o ?p ?s ?ps ?g ?a ?l ?h)
    :precondition (and (Handling ?o ?p ?g ?a ?l ?h) (RestsOn ?o ?p ?s ?ps)
                       (AtPose ?o ?p) (AtPose ?s ?ps) (HandEmpty) (AtConf ?a)
                       (not (Covered ?o)) (not (UnsafeHandling ?o ?h)))
    :effect (and (AtGrasp ?o ?g) (AtConf ?l)
                 (not (AtPose ?o ?p)) (not (HandEmpty)) (not (AtConf ?a))))

  (:action place
    :parameters (?o ?p ?g ?a ?l ?h)
    :precondition (and (Handling ?o ?p ?g ?a ?l ?h) (PutOnTable ?o ?p)
                       (AtGrasp ?o ?g) (AtConf ?l)
                       (not (UnsafePlacement ?o ?p)) (not (UnsafeHandling ?o ?h)))
    :effect (and (AtPose ?o ?p) (HandEmpty) (AtConf ?a)
                 (not (AtGrasp ?o ?g)) (not (AtConf ?l))))

  (:action stack
    :parameters (?o ?p ?s ?ps ?g ?a ?l ?h)
    :precondition (and (Handling ?o ?p ?g ?a ?l ?h) (RestsOn ?o ?p ?s ?ps)
                       (AtGrasp ?o ?g) (AtConf ?l) (AtPose ?s ?ps) (not (Unsupported ?o ?p))
                       (not (UnsafePlacement ?o ?p)) (not (UnsafeHandling ?o ?h)))
    :effect (and (AtPose ?o ?p) (HandEmpty) (AtConf ?a)
                 (not (AtGrasp ?o ?g)) (not (AtConf ?l))))
)
