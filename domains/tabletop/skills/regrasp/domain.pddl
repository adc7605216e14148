; Where it was decided to change the grasp, both grasps and the placement in between are chosen together.
(define (domain regrasp)
  (:predicates
    (Regrasped ?o ?p1 ?p2)         ; on its way from ?p1 to ?p2, ?o is put down in between and grasped anew
    (Takes ?o ?p ?g))              ; ?g is meant to take up ?o at ?p, and not at any other placement
)
