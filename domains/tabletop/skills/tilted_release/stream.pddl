(define (stream tilted-release)
  (:stream plan-bringing
    :inputs (?o ?p ?g)
    :domain (and (Placement ?o ?p) (Grasp ?o ?g) (Brings ?o ?p ?g))
    :outputs (?a ?l ?h)
    :certified (and (Conf ?a) (Conf ?l) (HandlingOf ?o ?h) (Laying ?o ?p ?g ?a ?l ?h)))

  (:stream plan-laying
    :inputs (?o ?p ?g)
    :domain (and (Layable ?o ?p) (Placement ?o ?p) (Grasp ?o ?g))
    :outputs (?a ?l ?h)
    :certified (and (Conf ?a) (Conf ?l) (HandlingOf ?o ?h) (Laying ?o ?p ?g ?a ?l ?h)))
)
