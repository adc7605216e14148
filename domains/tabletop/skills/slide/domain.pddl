; The hand pushes an object along the table until it hangs over the edge, where it can be gripped, or to its goal.
(define (domain slide)
  (:predicates
    (SlidableTo ?o ?p ?p2)         ; (Slidable ?o ?p), and ?p2 is straight ahead, ?o turned as it is
    (Slide ?o ?p ?p2 ?a ?l ?w))

  (:action slide
    :parameters (?o ?p ?p2 ?a ?l ?w)
    :precondition (and (Slide ?o ?p ?p2 ?a ?l ?w) (OnTable ?o ?p)
                       (AtPose ?o ?p) (HandEmpty) (AtConf ?a)
                       (not (Covered ?o)) (not (UnsafeSlide ?o ?w)))
    :effect (and (AtPose ?o ?p2) (AtConf ?l)
                 (not (AtPose ?o ?p)) (not (AtConf ?a))))
)
