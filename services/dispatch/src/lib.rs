//! The pool as a state machine: events in, effects out; time is an argument.
