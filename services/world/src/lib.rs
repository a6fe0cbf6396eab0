//! The rigid world: bodies, impacts, the gate, the replacement of a body by its fragments.
