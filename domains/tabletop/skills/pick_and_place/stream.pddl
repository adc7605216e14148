(define (stream pick-and-place)
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

  (:stream balance-without
    :inputs (?o ?p)
    :domain (Placement ?o ?p)
    :fluents (AtPose)
    :outputs (?b)
    :certified (BalancedWithout ?o ?p ?b))

  (:stream balance-with
    :inputs (?o ?p)
    :domain (Placement ?o ?p)
    :fluents (AtPose)
    :outputs (?b)
    :certified (BalancedWith ?o ?p ?b))
)
