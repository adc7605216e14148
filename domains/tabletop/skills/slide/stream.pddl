(define (stream slide)
  (:stream plan-sliding
    :inputs (?o ?p)
    :domain (Slidable ?o ?p)
    :outputs (?p2 ?a ?l ?w)
    :certified (and (Placement ?o ?p2) (OnTable ?o ?p2) (Exposed ?o ?p2)
                    (Conf ?a) (Conf ?l) (SlideOf ?o ?w) (Slide ?o ?p ?p2 ?a ?l ?w)))
)
