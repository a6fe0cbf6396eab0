//! The exports, read back and compared with the recording that they are of.

mod common;

mod glb;
mod moving;
mod options;
mod page;
mod pictures;
mod pieces;
mod sheets;
mod text;
