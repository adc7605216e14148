; The samplers of the tabletop domain. Each is a plain function in tamp.streams that a researcher may replace.
(define (stream tabletop)
  (:stream sample-grasp
    :inputs (?o)
    :domain (Movable ?o)
    :outputs (?g)
    :certified (Grasp ?o ?g))

  (:stream sample-placement
    :inputs (?o ?s)
    :domain (Placeable ?o ?s)
    :outputs (?p)
    :certified (and (Placement ?o ?p) (OnTable ?o ?p) (PutOnTable ?o ?p) (InRegion ?o ?p ?s)))

  (:stream sample-stacking
    :inputs (?o ?s ?ps)
    :domain (and (Stackable ?o ?s) (Placement ?s ?ps))
    :outputs (?p)
    :certified (and (Placement ?o ?p) (RestsOn ?o ?p ?s ?ps)))

  (:stream sample-insertion
    :inputs (?o ?s ?ps)
    :domain (and (Insertable ?o ?s) (Placement ?s ?ps))
    :outputs (?p)
    :certified (and (Placement ?o ?p) (RestsOn ?o ?p ?s ?ps) (Contained ?o ?p ?s ?ps)))

  (:stream inverse-kinematics
    :inputs (?o ?p ?g)
    :domain (and (Movable ?o) (Placement ?o ?p) (Grasp ?o ?g))
    :outputs (?a ?l ?h)
    :certified (and (Conf ?a) (Conf ?l) (HandlingOf ?o ?h) (Handling ?o ?p ?g ?a ?l ?h)))

  ; Where it was decided to change the grasp, both grasps and the placement in between are chosen together.
  (:stream sample-regrasp
    :inputs (?o ?p1 ?p2)
    :domain (Regrasped ?o ?p1 ?p2)
    :outputs (?g1 ?p ?g2)
    :certified (and (Grasp ?o ?g1) (Grasp ?o ?g2) (Placement ?o ?p) (OnTable ?o ?p) (LaidOnTable ?o ?p)
                    (Takes ?o ?p1 ?g1) (Brings ?o ?p ?g1) (Takes ?o ?p ?g2) (Brings ?o ?p2 ?g2)))

  (:stream regrasp-kinematics
    :inputs (?o ?p ?g)
    :domain (and (Placement ?o ?p) (Grasp ?o ?g) (Takes ?o ?p ?g))
    :outputs (?a ?l ?h)
    :certified (and (Conf ?a) (Conf ?l) (HandlingOf ?o ?h) (Handling ?o ?p ?g ?a ?l ?h)))

  (:stream plan-bringing
    :inputs (?o ?p ?g)
    :domain (and (Placement ?o ?p) (Grasp ?o ?g) (Brings ?o ?p ?g))
    :outputs (?a ?l ?h)
    :certified (and (Conf ?a) (Conf ?l) (HandlingOf ?o ?h) (Laying ?o ?p ?g ?a ?l ?h)))

  (:stream plan-laying
    :inputs (?o ?p ?g)
    :domain (and (Layable ?o ?p) (Placement ?o ?p) (Grasp ?o ?g))
    :outputs (?a ?l ?h)
    :certified (and (Conf ?a) (Conf ?l) (HandlingOf ?o ?h) (Laying ?o ?p ?g ?a ?l ?h)))

  ; Of what would lie too flat for any hand on some face, grasp and place are chosen together where it is put aside: on
  ; another face, or laid on that one.
  (:stream sample-put-aside
    :inputs (?o ?p1)
    :domain (LiesFlat ?o ?p1)
    :outputs (?g ?p)
    :certified (and (Grasp ?o ?g) (Placement ?o ?p) (OnTable ?o ?p) (LaidOnTable ?o ?p) (Brings ?o ?p ?g)))

  (:stream sample-laid-aside
    :inputs (?o ?p1)
    :domain (LiesFlat ?o ?p1)
    :outputs (?g ?p)
    :certified (and (Grasp ?o ?g) (Placement ?o ?p) (Layable ?o ?p) (LaidOnTable ?o ?p)))

  (:stream plan-sliding
    :inputs (?o ?p)
    :domain (Slidable ?o ?p)
    :outputs (?p2 ?a ?l ?w)
    :certified (and (Placement ?o ?p2) (OnTable ?o ?p2) (Exposed ?o ?p2)
                    (Conf ?a) (Conf ?l) (SlideOf ?o ?w) (Slide ?o ?p ?p2 ?a ?l ?w)))

  (:stream plan-toppling
    :inputs (?o ?p)
    :domain (Topplable ?o ?p)
    :outputs (?p2 ?a ?l ?w)
    :certified (and (Placement ?o ?p2) (OnTable ?o ?p2) (Exposed ?o ?p2)
                    (Conf ?a) (Conf ?l) (SlideOf ?o ?w) (Topple ?o ?p ?p2 ?a ?l ?w)))

  (:stream sample-exposed-grasp
    :inputs (?o ?p)
    :domain (Exposed ?o ?p)
    :outputs (?g)
    :certified (Grasp ?o ?g))

  (:stream plan-nudging
    :inputs (?o ?p ?p2)
    :domain (Nudgeable ?o ?p ?p2)
    :outputs (?a ?l ?w)
    :certified (and (Conf ?a) (Conf ?l) (SlideOf ?o ?w) (Nudge ?o ?p ?p2 ?a ?l ?w)))

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

  (:stream test-cfree-slide
    :inputs (?o ?w ?o2 ?p2)
    :domain (and (SlideOf ?o ?w) (Placement ?o2 ?p2))
    :certified (CFreeSlide ?o ?w ?o2 ?p2))
)
