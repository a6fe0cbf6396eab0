//! What needs nothing but the sources.

mod tidy;
