(define (stream shake)
  (:stream plan-shake
    :inputs (?o ?g)
    :domain (and (Shakeable ?o) (Grasp ?o ?g))
    :outputs (?q ?m)
    :certified (and (Conf ?q) (ShakeMotion ?o ?g ?q ?m))))
