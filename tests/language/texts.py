"""Small files of both kinds that the tests read and break."""

DOMAIN = """
; a hand, blocks and a stove
(define (domain Kitchen)
  (:requirements :adl :typing :derived-predicates :action-costs)
  (:types block region - physical  stove - region  pose)
  (:constants Oven - stove  tray)
  (:predicates (AtPose ?b - block ?p - pose) (Holding ?b - block) (HandEmpty) (Cooked ?b) (CFree ?b ?p ?b2 ?p2)
               (Unsafe ?b ?p) (Above ?a ?b) (On ?a ?b))
  (:functions (total-cost) - number (Distance ?p1 ?p2 - pose) - number)
  (:action Place
    :parameters (?b - block ?p - pose ?r - (either region stove))
    :precondition (and (Holding ?b) (not (Unsafe ?b ?p))
                       (forall (?b2 - block ?p2 - pose) (imply (AtPose ?b2 ?p2) (or (= ?b ?b2) (CFree ?b ?p ?b2 ?p2)))))
    :effect (and (AtPose ?b ?p) (HandEmpty) (not (Holding ?b))
                 (when (On ?b oven) (Cooked ?b))
                 (forall (?o - block) (when (On ?o ?b) (and (Cooked ?o) (not (On ?o tray)))))
                 (increase (total-cost) (+ 2 (Distance ?p ?p)))))
  (:action wait :effect ())
  (:derived (Above ?a ?b) (or (On ?a ?b) (exists (?c) (and (On ?a ?c) (Above ?c ?b)))))
  (:derived (Unsafe ?b ?p) (exists (?b2 ?p2) (and (AtPose ?b2 ?p2) (not (CFree ?b ?p ?b2 ?p2)))))
)
"""

STREAMS = """
(define (stream kitchen)
  (:function (Distance ?p1 ?p2) (and (Pose ?p1) (Pose ?p2)))
  (:predicate (Collision ?b ?p) (Free ?b ?p))
  (:rule :inputs (?b ?p) :domain (Kin ?b ?p) :certified (and (Free ?b ?p) (Reachable ?b)))
  (:stream sample-pose
    :inputs (?b - block ?r)
    :domain (and (Placeable ?b ?r))
    :outputs (?p - pose)
    :certified (and (Contained ?b ?p ?r) (and (Free ?b ?p))))
  (:stream test-cfree
    :inputs (?b ?p ?b2 ?p2)
    :domain (and (Free ?b ?p) (Free ?b2 ?p2))
    :outputs ()
    :certified (CFree ?b ?p ?b2 ?p2))
  (:wild-stream motion
    :inputs (?p1 ?p2)
    :fluents (AtPose On)
    :outputs (?t)
    :certified (Motion ?p1 ?t ?p2))
  (:stream spawn :outputs (?b) :certified (block ?b))
)
"""
