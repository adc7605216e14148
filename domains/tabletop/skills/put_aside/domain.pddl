; Of what would lie too flat for any hand on some face, grasp and place are chosen together where it is put aside: on
; another face, or laid on that one.
(define (domain put-aside)
  (:predicates
    (LiesFlat ?o ?p))              ; taken from ?p, ?o is put aside with care: on some face it lies flat
)
