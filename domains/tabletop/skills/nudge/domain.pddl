; The hand pushes an object on a little within what it lies in.
(define (domain nudge)
  (:predicates
    (Nudgeable ?o ?p ?p2)          ; from ?p to ?p2 it is a few centimetres, within what ?o lies in
    (Nudge ?o ?p ?p2 ?a ?l ?w))

  (:action nudge
    :parameters (?o ?p ?p2 ?s ?ps ?a ?l ?w)
    :precondition (and (Nudge ?o ?p ?p2 ?a ?l ?w) (RestsOn ?o ?p ?s ?ps) (RestsOn ?o ?p2 ?s ?ps)
                       (AtPose ?o ?p) (AtPose ?s ?ps) (HandEmpty) (AtConf ?a)
                       (not (Covered ?o)) (not (UnsafeSlide ?o ?w)))
    :effect (and (AtPose ?o ?p2) (AtConf ?l)
                 (not (AtPose ?o ?p)) (not (AtConf ?a))))
)
