; Tests that all skills of the tabletop share.
(define (stream tabletop)
  (:stream test-cfree-placements
    :inputs (?o ?p ?o2 ?p2)
    :domain (and (MayMove ?o) (Placement ?o ?p) (Placement ?o2 ?p2))
    :certified (CFreePlacements ?o ?p ?o2 ?p2))

  (:stream test-cfree-handling
    :inputs (?o ?h ?o2 ?p2)
    :domain (and (HandlingOf ?o ?h) (Placement ?o2 ?p2))
    :certified (CFreeHandling ?o ?h ?o2 ?p2))
)
