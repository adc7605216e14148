; Pick, place and unstack at a table, in the names of PDDLStream's tabletop examples.
;
; ?o object   ?p placement of an object (a pose in the world and what it rests on)   ?s region or supporting object
; ?g grasp    ?h handling: approach, grasp and lift of an object at a placement, read backwards to put it down
; ?w slide: the hand pushes an object along the table until it hangs over the edge, where it can be gripped, or over one
;   of its own edges until it falls onto another face, or nudges it within what it lies in
; Laying is letting something go before it is all the way down: tilted, on one edge, to fall flat, or above what it shall
; lie in, to fall straight down.
; ?q arm configuration: a handling begins empty-handed at ?a and ends holding at ?l       ?t path between two of them
(define (domain tabletop)
  (:requirements :strips :equality :negative-preconditions :existential-preconditions :derived-predicates)

  (:predicates
    ; what streams and the task certify
    (Movable ?o) (Region ?s) (Placeable ?o ?s) (Stackable ?o ?s) (Insertable ?o ?s)
    (Grasp ?o ?g) (Placement ?o ?p) (Conf ?q)
    (OnTable ?o ?p)                ; rests on nothing that moves
    (PutOnTable ?o ?p)             ; is put there by any grasp, and not only by the one that was chosen with the place
    (InRegion ?o ?p ?s)
    (RestsOn ?o ?p ?s ?ps)         ; ?o at ?p stands on ?s at ?ps
    (Contained ?o ?p ?s ?ps)
    (Handling ?o ?p ?g ?a ?l ?h) (HandlingOf ?o ?h)
    (Layable ?o ?p)                ; a hand that puts ?o down at ?p may be in its own way
    (LaidOnTable ?o ?p)            ; what is laid down at ?p rests on nothing that moves
    (LiesFlat ?o ?p)               ; taken from ?p, ?o is put aside with care: on some face it lies flat
    (Regrasped ?o ?p1 ?p2)         ; on its way from ?p1 to ?p2, ?o is put down in between and grasped anew
    (Takes ?o ?p ?g)               ; ?g is meant to take up ?o at ?p, and not at any other placement
    (Brings ?o ?p ?g)              ; ?g is meant to bring ?o to ?p: put down, or laid down where it has to be
    (Laying ?o ?p ?g ?a ?l ?h)
    (Slidable ?o ?p)               ; no hand can grasp ?o at ?p, but it may be slid from there
    (Slide ?o ?p ?p2 ?a ?l ?w) (SlideOf ?o ?w)
    (Topplable ?o ?p)              ; no hand can grasp ?o at ?p, but it may be toppled there
    (Topple ?o ?p ?p2 ?a ?l ?w)
    (Exposed ?o ?p)                ; ?o was slid or toppled to ?p, where a hand can take it
    (Nudgeable ?o ?p ?p2)          ; from ?p to ?p2 it is a few centimetres, within what ?o lies in
    (Nudge ?o ?p ?p2 ?a ?l ?w)
    (FreeMotion ?q1 ?q2 ?t)
    (HoldingMotion ?o ?g ?q1 ?q2 ?t)
    (CFreePlacements ?o ?p ?o2 ?p2)
    (CFreeHandling ?o ?h ?o2 ?p2)
    (CFreeSlide ?o ?w ?o2 ?p2)
    ; what actions change
    (AtPose ?o ?p) (AtGrasp ?o ?g) (HandEmpty) (AtConf ?q)
    ; what follows from those
    (Covered ?o) (Unsupported ?o ?p) (UnsafePlacement ?o ?p) (UnsafeHandling ?o ?h) (UnsafeSlide ?o ?w)
    (On ?o ?s) (In ?o ?s) (Holding ?o))

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
    :precondition (and (Handling ?o ?p ?g ?a ?l ?h) (OnTable ?o ?p)
                       (not (Slidable ?o ?p)) (not (Topplable ?o ?p))
                       (AtPose ?o ?p) (HandEmpty) (AtConf ?a)
                       (not (Covered ?o)) (not (UnsafeHandling ?o ?h)))
    :effect (and (AtGrasp ?o ?g) (AtConf ?l)
                 (not (AtPose ?o ?p)) (not (HandEmpty)) (not (AtConf ?a))))

  (:action unstack
    :parameters (?o ?p ?s ?ps ?g ?a ?l ?h)
    :precondition (and (Handling ?o ?p ?g ?a ?l ?h) (RestsOn ?o ?p ?s ?ps)
                       (AtPose ?o ?p) (AtPose ?s ?ps) (HandEmpty) (AtConf ?a)
                       (not (Covered ?o)) (not (UnsafeHandling ?o ?h)))
    :effect (and (AtGrasp ?o ?g) (AtConf ?l)
                 (not (AtPose ?o ?p)) (not (HandEmpty)) (not (AtConf ?a))))

  (:action place
    :parameters (?o ?p ?g ?a ?l ?h)
    :precondition (and (Handling ?o ?p ?g ?a ?l ?h) (PutOnTable ?o ?p)
                       (AtGrasp ?o ?g) (AtConf ?l)
                       (not (UnsafePlacement ?o ?p)) (not (UnsafeHandling ?o ?h)))
    :effect (and (AtPose ?o ?p) (HandEmpty) (AtConf ?a)
                 (not (AtGrasp ?o ?g)) (not (AtConf ?l))))

  (:action stack
    :parameters (?o ?p ?s ?ps ?g ?a ?l ?h)
    :precondition (and (Handling ?o ?p ?g ?a ?l ?h) (RestsOn ?o ?p ?s ?ps)
                       (AtGrasp ?o ?g) (AtConf ?l) (AtPose ?s ?ps) (not (Unsupported ?o ?p))
                       (not (UnsafePlacement ?o ?p)) (not (UnsafeHandling ?o ?h)))
    :effect (and (AtPose ?o ?p) (HandEmpty) (AtConf ?a)
                 (not (AtGrasp ?o ?g)) (not (AtConf ?l))))

  (:action lay
    :parameters (?o ?p ?g ?a ?l ?h)
    :precondition (and (Laying ?o ?p ?g ?a ?l ?h) (LaidOnTable ?o ?p)
                       (AtGrasp ?o ?g) (AtConf ?l)
                       (not (UnsafePlacement ?o ?p)) (not (UnsafeHandling ?o ?h)))
    :effect (and (AtPose ?o ?p) (HandEmpty) (AtConf ?a)
                 (not (AtGrasp ?o ?g)) (not (AtConf ?l))))

  (:action lay-on
    :parameters (?o ?p ?s ?ps ?g ?a ?l ?h)
    :precondition (and (Laying ?o ?p ?g ?a ?l ?h) (RestsOn ?o ?p ?s ?ps)
                       (AtGrasp ?o ?g) (AtConf ?l) (AtPose ?s ?ps) (not (Unsupported ?o ?p))
                       (not (UnsafePlacement ?o ?p)) (not (UnsafeHandling ?o ?h)))
    :effect (and (AtPose ?o ?p) (HandEmpty) (AtConf ?a)
                 (not (AtGrasp ?o ?g)) (not (AtConf ?l))))

  (:action slide
    :parameters (?o ?p ?p2 ?a ?l ?w)
    :precondition (and (Slide ?o ?p ?p2 ?a ?l ?w) (OnTable ?o ?p)
                       (AtPose ?o ?p) (HandEmpty) (AtConf ?a)
                       (not (Covered ?o)) (not (UnsafeSlide ?o ?w)))
    :effect (and (AtPose ?o ?p2) (AtConf ?l)
                 (not (AtPose ?o ?p)) (not (AtConf ?a))))

  (:action topple
    :parameters (?o ?p ?p2 ?a ?l ?w)
    :precondition (and (Topple ?o ?p ?p2 ?a ?l ?w) (OnTable ?o ?p)
                       (AtPose ?o ?p) (HandEmpty) (AtConf ?a)
                       (not (Covered ?o)) (not (UnsafeSlide ?o ?w)))
    :effect (and (AtPose ?o ?p2) (AtConf ?l)
                 (not (AtPose ?o ?p)) (not (AtConf ?a))))

  (:action nudge
    :parameters (?o ?p ?p2 ?s ?ps ?a ?l ?w)
    :precondition (and (Nudge ?o ?p ?p2 ?a ?l ?w) (RestsOn ?o ?p ?s ?ps) (RestsOn ?o ?p2 ?s ?ps)
                       (AtPose ?o ?p) (AtPose ?s ?ps) (HandEmpty) (AtConf ?a)
                       (not (Covered ?o)) (not (UnsafeSlide ?o ?w)))
    :effect (and (AtPose ?o ?p2) (AtConf ?l)
                 (not (AtPose ?o ?p)) (not (AtConf ?a))))

  ; What stands on something must leave before it ...
  (:derived (Covered ?s)
    (exists (?o ?p ?ps) (and (RestsOn ?o ?p ?s ?ps) (AtPose ?o ?p) (AtPose ?s ?ps))))

  ; ... and what a placement rests on must be there before it, all of it.
  (:derived (Unsupported ?o ?p)
    (exists (?s ?ps) (and (RestsOn ?o ?p ?s ?ps) (not (AtPose ?s ?ps)))))

  (:derived (UnsafePlacement ?o ?p)
    (exists (?o2 ?p2) (and (Placement ?o ?p) (Placement ?o2 ?p2) (not (= ?o ?o2))
                           (AtPose ?o2 ?p2) (not (CFreePlacements ?o ?p ?o2 ?p2)))))

  (:derived (UnsafeHandling ?o ?h)
    (exists (?o2 ?p2) (and (HandlingOf ?o ?h) (Placement ?o2 ?p2) (not (= ?o ?o2))
                           (AtPose ?o2 ?p2) (not (CFreeHandling ?o ?h ?o2 ?p2)))))

  (:derived (UnsafeSlide ?o ?w)
    (exists (?o2 ?p2) (and (SlideOf ?o ?w) (Placement ?o2 ?p2) (not (= ?o ?o2))
                           (AtPose ?o2 ?p2) (not (CFreeSlide ?o ?w ?o2 ?p2)))))

  (:derived (On ?o ?s)
    (or (exists (?p) (and (InRegion ?o ?p ?s) (AtPose ?o ?p)))
        (exists (?p ?ps) (and (RestsOn ?o ?p ?s ?ps) (AtPose ?o ?p) (AtPose ?s ?ps)))))

  (:derived (In ?o ?s)
    (exists (?p ?ps) (and (Contained ?o ?p ?s ?ps) (AtPose ?o ?p) (AtPose ?s ?ps))))

  (:derived (Holding ?o)
    (exists (?g) (and (Grasp ?o ?g) (AtGrasp ?o ?g))))
)
