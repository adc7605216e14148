; What all skills of the tabletop share: what stands where, on what, and what is in each other's way. The names are those
; of PDDLStream's tabletop examples. Each skill in skills/ adds its own predicates and actions.
;
; ?o object   ?p placement of an object (a pose in the world and what it rests on)   ?s region or supporting object
; ?g grasp    ?h handling: approach, grasp and lift of an object at a placement, read backwards to put it down
; ?q arm configuration: a handling begins empty-handed at ?a and ends holding at ?l       ?t path between two of them
(define (domain tabletop)
  (:requirements :strips :equality :negative-preconditions :existential-preconditions :derived-predicates)

  (:predicates
    ; what streams and the task certify
    (MayMove ?o)                   ; nothing is asked about two objects of which neither may
    (Movable ?o)                   ; a hand may take ?o wherever it stands
    (Region ?s)
    (Grasp ?o ?g) (Placement ?o ?p) (Conf ?q)
    (OnTable ?o ?p)                ; rests on nothing that moves
    (PutOnTable ?o ?p)             ; is put there by any grasp, and not only by the one that was chosen with the place
    (LaidOnTable ?o ?p)            ; what is laid down at ?p rests on nothing that moves
    (InRegion ?o ?p ?s)
    (RestsOn ?o ?p ?s ?ps)         ; ?o at ?p stands on ?s at ?ps, and does not stay there without it
    (Contained ?o ?p ?s ?ps)
    (Handling ?o ?p ?g ?a ?l ?h) (HandlingOf ?o ?h)
    (Slidable ?o ?p)               ; no hand can grasp ?o at ?p, but it may be slid from there
    (Topplable ?o ?p)              ; no hand can grasp ?o at ?p, but it may be toppled there
    (CFreePlacements ?o ?p ?o2 ?p2)
    (CFreeHandling ?o ?h ?o2 ?p2)
    ; what actions change
    (AtPose ?o ?p) (AtGrasp ?o ?g) (HandEmpty) (AtConf ?q)
    ; what follows from those
    (Covered ?o) (Unsupported ?o ?p) (UnsafePlacement ?o ?p) (UnsafeHandling ?o ?h)
    (On ?o ?s) (In ?o ?s) (Holding ?o))

  ; What stands on something must leave before it ...
  (:derived (Covered ?s)
    (exists (?o ?p ?ps) (and (RestsOn ?o ?p ?s ?ps) (AtPose ?o ?p) (AtPose ?s ?ps))))

  ; ... and what a placement rests on must be there before it, all of it.
  (:derived (Unsupported ?o ?p)
    (exists (?s ?ps) (and (RestsOn ?o ?p ?s ?ps) (not (AtPose ?s ?ps)))))

  (:derived (UnsafePlacement ?o ?p)
    (exists (?o2 ?p2) (and (MayMove ?o) (Placement ?o ?p) (Placement ?o2 ?p2) (not (= ?o ?o2))
                           (AtPose ?o2 ?p2) (not (CFreePlacements ?o ?p ?o2 ?p2)))))

  (:derived (UnsafeHandling ?o ?h)
    (exists (?o2 ?p2) (and (HandlingOf ?o ?h) (Placement ?o2 ?p2) (not (= ?o ?o2))
                           (AtPose ?o2 ?p2) (not (CFreeHandling ?o ?h ?o2 ?p2)))))

  (:derived (On ?o ?s)
    (or (exists (?p) (and (InRegion ?o ?p ?s) (AtPose ?o ?p)))
        (exists (?p ?ps) (and (RestsOn ?o ?p ?s ?ps) (AtPose ?o ?p) (AtPose ?s ?ps)))))

  (:derived (In ?o ?s)
    (exists (?p ?ps) (and (Contained ?o ?p ?s ?ps) (AtPose ?o ?p) (AtPose ?s ?ps))))

  (:derived (Holding ?o)
    (exists (?g) (and (Grasp ?o ?g) (AtGrasp ?o ?g))))
)
