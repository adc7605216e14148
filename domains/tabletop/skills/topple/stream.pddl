(define (stream topple)
  (:stream plan-toppling
    :inputs (?o ?p)
    :domain (Topplable ?o ?p)
    :outputs (?p2 ?a ?l ?w)
    :certified (and (Placement ?o ?p2) (OnTable ?o ?p2) (Exposed ?o ?p2)
                    (Conf ?a) (Conf ?l) (SlideOf ?o ?w) (Topple ?o ?p ?p2 ?a ?l ?w)))
)
