; What slides, topples and nudges have in common: ?w is a push of an object by the closed or open hand.
(define (domain push)
  (:predicates
    (SlideOf ?o ?w) (Exposed ?o ?p)                ; a hand can take ?o at ?p, where it stands or was slid or toppled to
    (CFreeSlide ?o ?w ?o2 ?p2) (UnsafeSlide ?o ?w))

  (:derived (UnsafeSlide ?o ?w)
    (exists (?o2 ?p2) (and (SlideOf ?o ?w) (Placement ?o2 ?p2) (not (= ?o ?o2))
                           (AtPose ?o2 ?p2) (not (CFreeSlide ?o ?w ?o2 ?p2)))))
)
