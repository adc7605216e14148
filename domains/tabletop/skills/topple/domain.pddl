; The hand pushes an object over one of its own edges until it falls onto another face.
(define (domain topple)
  (:predicates
    (Topple ?o ?p ?p2 ?a ?l ?w))

  (:action topple
    :parameters (?o ?p ?p2 ?a ?l ?w)
    :precondition (and (Topple ?o ?p ?p2 ?a ?l ?w) (OnTable ?o ?p)
                       (AtPose ?o ?p) (HandEmpty) (AtConf ?a)
                       (not (Covered ?o)) (not (UnsafeSlide ?o ?w)))
    :effect (and (AtPose ?o ?p2) (AtConf ?l)
                 (not (AtPose ?o ?p)) (not (AtConf ?a))))
)
