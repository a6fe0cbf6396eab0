//! Files as Cullet reads and writes them: regular files alone are opened, what is written is whole
//! or not there, and what lasts has a checksum.

pub mod cells;
pub mod claim;
pub mod clock;
pub mod output;
pub mod process_memory;
pub mod regular;
pub mod set_aside;
pub mod state;
