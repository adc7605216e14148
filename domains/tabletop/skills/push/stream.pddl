(define (stream push)
  (:stream sample-exposed-grasp
    :inputs (?o ?p)
    :domain (Exposed ?o ?p)
    :outputs (?g)
    :certified (Grasp ?o ?g))

  (:stream test-cfree-slide
    :inputs (?o ?w ?o2 ?p2)
    :domain (and (SlideOf ?o ?w) (Placement ?o2 ?p2))
    :certified (CFreeSlide ?o ?w ?o2 ?p2))
)
