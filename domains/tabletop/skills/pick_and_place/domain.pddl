; An object is taken from the table or from what it stands on, and put down on either.
(define (domain pick-and-place)
  (:predicates
    (Placeable ?o ?s) (Stackable ?o ?s) (Insertable ?o ?s)
    (BalancedWithout ?o ?p ?b)     ; the pile that ?o at ?p belongs to stays at rest when it is taken
    (BalancedWith ?o ?p ?b))       ; and when it is put there

  (:action pick
    :parameters (?o ?p ?g ?a ?l ?h)
    :precondition (and (Handling ?o ?p ?g ?a ?l ?h) (OnTable ?o ?p)
                       (not (Slidable ?o ?p)) (not (Topplable ?o ?p))
                       (AtPose ?o ?p) (HandEmpty) (AtConf ?a)
                       (not (Covered ?o)) (not (UnsafeHandling ?o ?h)))
    :effect (and (AtGrasp ?o ?g) (AtConf ?l)
                 (not (AtPose ?o ?p)) (not (HandEmpty)) (not (AtConf ?a))))

  (:action unstack
    :parameters (?o ?p ?s ?ps ?b ?g ?a ?l ?h)
    :precondition (and (Handling ?o ?p ?g ?a ?l ?h) (RestsOn ?o ?p ?s ?ps) (BalancedWithout ?o ?p ?b)
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
    :parameters (?o ?p ?s ?ps ?b ?g ?a ?l ?h)
    :precondition (and (Handling ?o ?p ?g ?a ?l ?h) (RestsOn ?o ?p ?s ?ps) (BalancedWith ?o ?p ?b)
                       (AtGrasp ?o ?g) (AtConf ?l) (AtPose ?s ?ps) (not (Unsupported ?o ?p))
                       (not (UnsafePlacement ?o ?p)) (not (UnsafeHandling ?o ?h)))
    :effect (and (AtPose ?o ?p) (HandEmpty) (AtConf ?a)
                 (not (AtGrasp ?o ?g)) (not (AtConf ?l))))
)
