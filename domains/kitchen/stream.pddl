; The tabletop samplers that cooking and cleaning need.
(define (stream kitchen)
  (:stream sample-grasp
    :inputs (?o)
    :domain (Movable ?o)
    :outputs (?g)
    :certified (Grasp ?o ?g))

  (:stream sample-placement
    :inputs (?o ?s)
    :domain (Placeable ?o ?s)
    :outputs (?p)
    :certified (and (Placement ?o ?p) (InRegion ?o ?p ?s)))

  (:stream inverse-kinematics
    :inputs (?o ?p ?g)
    :domain (and (Placement ?o ?p) (Grasp ?o ?g))
    :outputs (?a ?l ?h)
    :certified (and (Conf ?a) (Conf ?l) (HandlingOf ?o ?h) (Handling ?o ?p ?g ?a ?l ?h)))

  (:stream plan-free-motion
    :inputs (?q1 ?q2)
    :domain (and (Conf ?q1) (Conf ?q2))
    :fluents (AtPose)
    :outputs (?t)
    :certified (FreeMotion ?q1 ?q2 ?t))

  (:stream plan-holding-motion
    :inputs (?o ?g ?q1 ?q2)
    :domain (and (Grasp ?o ?g) (Conf ?q1) (Conf ?q2))
    :fluents (AtPose)
    :outputs (?t)
    :certified (HoldingMotion ?o ?g ?q1 ?q2 ?t))

  (:stream test-cfree-placements
    :inputs (?o ?p ?o2 ?p2)
    :domain (and (Placement ?o ?p) (Placement ?o2 ?p2))
    :certified (CFreePlacements ?o ?p ?o2 ?p2))

  (:stream test-cfree-handling
    :inputs (?o ?h ?o2 ?p2)
    :domain (and (HandlingOf ?o ?h) (Placement ?o2 ?p2))
    :certified (CFreeHandling ?o ?h ?o2 ?p2))
)
