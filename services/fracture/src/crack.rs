//! crack
