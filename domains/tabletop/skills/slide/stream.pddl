(define (stream slide)
  (:stream plan-sliding
    :inputs (?o ?p)
    :domain (Slidable ?o ?p)
    :outputs (?p2 ?a ?l ?w)
    :certified (and (Placement ?o ?p2) (OnTable ?o ?p2) (Exposed ?o ?p2)
                    (Conf ?a) (Conf ?l) (SlideOf ?o ?w) (Slide ?o ?p ?p2 ?a ?l ?w)))

  ; Two slides after each other get an object to ends that no straight one leads to.
  (:stream plan-detour
    :inputs (?o ?p)
    :domain (Slidable ?o ?p)
    :outputs (?p1 ?a1 ?l1 ?w1 ?p2 ?a2 ?l2 ?w2)
    :certified (and (Placement ?o ?p1) (OnTable ?o ?p1) (Placement ?o ?p2) (OnTable ?o ?p2) (Exposed ?o ?p2)
                    (Conf ?a1) (Conf ?l1) (SlideOf ?o ?w1) (Slide ?o ?p ?p1 ?a1 ?l1 ?w1)
                    (Conf ?a2) (Conf ?l2) (SlideOf ?o ?w2) (Slide ?o ?p1 ?p2 ?a2 ?l2 ?w2)))

  (:stream plan-sliding-to
    :inputs (?o ?p ?p2)
    :domain (SlidableTo ?o ?p ?p2)
    :outputs (?a ?l ?w)
    :certified (and (Conf ?a) (Conf ?l) (SlideOf ?o ?w) (Slide ?o ?p ?p2 ?a ?l ?w)))
)
