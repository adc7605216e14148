(define (stream move)
  (:stream plan-free-motion
    :inputs (?q1 ?q2)
    :domain (and (Conf ?q1) (Conf ?q2))
    :fluents (AtPose)
    :outputs (?t)
    :certified (FreeMotion ?q1 ?q2 ?t))

  (:stream plan-holding-motion
    :inputs (?o ?g ?q1 ?q2)
    :domain (and (Grasp ?o ?g) (Conf ?q1) (Conf ?q2))
    :fluents (AtPose)
    :outputs (?t)
    :certified (HoldingMotion ?o ?g ?q1 ?q2 ?t))
)
