; Cook and clean: what stands in a sink can be cleaned, and what is clean and stands on a stove can be cooked.
; Objects move as in the tabletop domain, whose samplers serve here too; they stand on the table only.
(define (domain kitchen)
  (:requirements :strips :equality :negative-preconditions :existential-preconditions :derived-predicates)

  (:predicates
    ; what streams and the task certify
    (Movable ?o) (Placeable ?o ?s) (Sink ?s) (Stove ?s)
    (Grasp ?o ?g) (Placement ?o ?p) (InRegion ?o ?p ?s) (Conf ?q)
    (Handling ?o ?p ?g ?a ?l ?h) (HandlingOf ?o ?h)
    (FreeMotion ?q1 ?q2 ?t) (HoldingMotion ?o ?g ?q1 ?q2 ?t)
    (CFreePlacements ?o ?p ?o2 ?p2) (CFreeHandling ?o ?h ?o2 ?p2)
    ; what actions change
    (AtPose ?o ?p) (AtGrasp ?o ?g) (HandEmpty) (AtConf ?q) (Cleaned ?o) (Cooked ?o)
    ; what follows from those
    (UnsafePlacement ?o ?p) (UnsafeHandling ?o ?h) (On ?o ?s))

  (:action move-free
    :parameters (?q1 ?q2 ?t)
    :precondition (and (FreeMotion ?q1 ?q2 ?t) (AtConf ?q1) (HandEmpty))
    :effect (and (AtConf ?q2) (not (AtConf ?q1))))

  (:action move-holding
    :parameters (?o ?g ?q1 ?q2 ?t)
    :precondition (and (HoldingMotion ?o ?g ?q1 ?q2 ?t) (AtConf ?q1) (AtGrasp ?o ?g))
    :effect (and (AtConf ?q2) (not (AtConf ?q1))))

  (:action pick
    :parameters (?o ?p ?g ?a ?l ?h)
    :precondition (and (Handling ?o ?p ?g ?a ?l ?h) (AtPose ?o ?p) (HandEmpty) (AtConf ?a)
                       (not (UnsafeHandling ?o ?h)))
    :effect (and (AtGrasp ?o ?g) (AtConf ?l) (not (AtPose ?o ?p)) (not (HandEmpty)) (not (AtConf ?a))))

  (:action place
    :parameters (?o ?p ?g ?a ?l ?h)
    :precondition (and (Handling ?o ?p ?g ?a ?l ?h) (AtGrasp ?o ?g) (AtConf ?l)
                       (not (UnsafePlacement ?o ?p)) (not (UnsafeHandling ?o ?h)))
    :effect (and (AtPose ?o ?p) (HandEmpty) (AtConf ?a) (not (AtGrasp ?o ?g)) (not (AtConf ?l))))

  (:action clean
    :parameters (?o ?s)
    :precondition (and (Sink ?s) (On ?o ?s))
    :effect (Cleaned ?o))

  (:action cook
    :parameters (?o ?s)
    :precondition (and (Stove ?s) (On ?o ?s) (Cleaned ?o))
    :effect (and (Cooked ?o) (not (Cleaned ?o))))

  (:derived (On ?o ?s) (exists (?p) (and (InRegion ?o ?p ?s) (AtPose ?o ?p))))

  (:derived (UnsafePlacement ?o ?p)
    (exists (?o2 ?p2) (and (Placement ?o ?p) (Placement ?o2 ?p2) (not (= ?o ?o2))
                           (AtPose ?o2 ?p2) (not (CFreePlacements ?o ?p ?o2 ?p2)))))

  (:derived (UnsafeHandling ?o ?h)
    (exists (?o2 ?p2) (and (HandlingOf ?o ?h) (Placement ?o2 ?p2) (not (= ?o ?o2))
                           (AtPose ?o2 ?p2) (not (CFreeHandling ?o ?h ?o2 ?p2)))))
)
