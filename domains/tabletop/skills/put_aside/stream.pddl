(define (stream put-aside)
  (:stream sample-put-aside
    :inputs (?o ?p1)
    :domain (LiesFlat ?o ?p1)
    :outputs (?g ?p)
    :certified (and (Grasp ?o ?g) (Placement ?o ?p) (OnTable ?o ?p) (LaidOnTable ?o ?p) (Brings ?o ?p ?g)))

  (:stream sample-laid-aside
    :inputs (?o ?p1)
    :domain (LiesFlat ?o ?p1)
    :outputs (?g ?p)
    :certified (and (Grasp ?o ?g) (Placement ?o ?p) (LaidOnTable ?o ?p) (Brings ?o ?p ?g)))

  ; What lies flat on every face can be taken up again, in the same plan, from where it hangs over the table's edge.
  (:stream sample-exposed-aside
    :inputs (?o ?p1)
    :domain (LiesFlat ?o ?p1)
    :outputs (?g ?p)
    :certified (and (Grasp ?o ?g) (Placement ?o ?p) (OnTable ?o ?p) (Exposed ?o ?p)
                    (LaidOnTable ?o ?p) (Brings ?o ?p ?g)))
)
