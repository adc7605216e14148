(define (stream nudge)
  (:stream plan-nudging
    :inputs (?o ?p ?p2)
    :domain (Nudgeable ?o ?p ?p2)
    :outputs (?a ?l ?w)
    :certified (and (Conf ?a) (Conf ?l) (SlideOf ?o ?w) (Nudge ?o ?p ?p2 ?a ?l ?w)))
)
