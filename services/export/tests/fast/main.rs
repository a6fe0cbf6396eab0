//! The exports, read back and compared with the recording that they are of.

mod common;

mod glb;
mod options;
mod pieces;
mod text;
