; Where it was decided to change the grasp, both grasps and the placement in between are chosen together.
(define (domain regrasp)
  (:predicates
    (RegraspedTo ?o ?p)            ; on its way to ?p, ?o is put down in between and grasped anew
    (Takes ?o ?p ?g))              ; ?g is meant to take up ?o at ?p, and not at any other placement
)
