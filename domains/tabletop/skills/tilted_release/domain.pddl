; Laying is letting something go before it is all the way down: tilted, on one edge, to fall flat, or above what it
; shall lie in, to fall straight down.
(define (domain tilted-release)
  (:predicates
    (Layable ?o ?p)                ; a hand that puts ?o down at ?p may be in its own way
    (Brings ?o ?p ?g)              ; ?g is meant to bring ?o to ?p: put down, or laid down where it has to be
    (Laying ?o ?p ?g ?a ?l ?h))

  (:action lay
    :parameters (?o ?p ?g ?a ?l ?h)
    :precondition (and (Laying ?o ?p ?g ?a ?l ?h) (LaidOnTable ?o ?p)
                       (AtGrasp ?o ?g) (AtConf ?l)
                       (not (UnsafePlacement ?o ?p)) (not (UnsafeHandling ?o ?h)))
    :effect (and (AtPose ?o ?p) (HandEmpty) (AtConf ?a)
                 (not (AtGrasp ?o ?g)) (not (AtConf ?l))))

  (:action lay-on
    :parameters (?o ?p ?s ?ps ?b ?g ?a ?l ?h)
    :precondition (and (Laying ?o ?p ?g ?a ?l ?h) (RestsOn ?o ?p ?s ?ps) (BalancedWith ?o ?p ?b)
                       (AtGrasp ?o ?g) (AtConf ?l) (AtPose ?s ?ps) (not (Unsupported ?o ?p))
                       (not (UnsafePlacement ?o ?p)) (not (UnsafeHandling ?o ?h)))
    :effect (and (AtPose ?o ?p) (HandEmpty) (AtConf ?a)
                 (not (AtGrasp ?o ?g)) (not (AtConf ?l))))
)
