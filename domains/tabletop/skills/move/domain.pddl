; The arm moves with an empty hand, or with an object in it.
(define (domain move)
  (:predicates
    (FreeMotion ?q1 ?q2 ?t)
    (HoldingMotion ?o ?g ?q1 ?q2 ?t))

  (:action move-free
    :parameters (?q1 ?q2 ?t)
    :precondition (and (FreeMotion ?q1 ?q2 ?t) (AtConf ?q1) (HandEmpty))
    :effect (and (AtConf ?q2) (not (AtConf ?q1))))

  (:action move-holding
    :parameters (?o ?g ?q1 ?q2 ?t)
    :precondition (and (HoldingMotion ?o ?g ?q1 ?q2 ?t) (AtConf ?q1) (AtGrasp ?o ?g))
    :effect (and (AtConf ?q2) (not (AtConf ?q1))))
)
