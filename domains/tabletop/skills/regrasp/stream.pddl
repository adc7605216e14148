(define (stream regrasp)
  (:stream sample-regrasp
    :inputs (?o ?p1 ?p2)
    :domain (and (Exposed ?o ?p1) (RegraspedTo ?o ?p2))
    :outputs (?g1 ?p ?g2)
    :certified (and (Grasp ?o ?g1) (Grasp ?o ?g2) (Placement ?o ?p) (OnTable ?o ?p) (LaidOnTable ?o ?p)
                    (Takes ?o ?p1 ?g1) (Brings ?o ?p ?g1) (Takes ?o ?p ?g2) (Brings ?o ?p2 ?g2)))

  (:stream regrasp-kinematics
    :inputs (?o ?p ?g)
    :domain (and (Placement ?o ?p) (Grasp ?o ?g) (Takes ?o ?p ?g))
    :outputs (?a ?l ?h)
    :certified (and (Conf ?a) (Conf ?l) (HandlingOf ?o ?h) (Handling ?o ?p ?g ?a ?l ?h)))
)
