; What is in the hand can be shaken.
(define (domain shake)
  (:predicates (Shakeable ?o) (ShakeMotion ?o ?g ?q ?m) (Shaken ?o))
  (:action shake
    :parameters (?o ?g ?q ?m)
    :precondition (and (ShakeMotion ?o ?g ?q ?m) (AtGrasp ?o ?g) (AtConf ?q))
    :effect (Shaken ?o)))
