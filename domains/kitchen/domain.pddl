; What stands in a sink can be cleaned, and what is clean and stands on a stove can be cooked.
(define (domain kitchen)
  (:predicates (Sink ?s) (Stove ?s) (Cleaned ?o) (Cooked ?o))

  (:action clean
    :parameters (?o ?s)
    :precondition (and (Sink ?s) (On ?o ?s) (HandEmpty))
    :effect (Cleaned ?o))

  (:action cook
    :parameters (?o ?s)
    :precondition (and (Stove ?s) (On ?o ?s) (Cleaned ?o) (HandEmpty))
    :effect (and (Cooked ?o) (not (Cleaned ?o))))
)
