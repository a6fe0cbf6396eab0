//! Nasty input: meshes, materials at every bound, blows at edges, corners and grazing, extreme
//! masses, and bodies broken again and again.

mod bodies;
mod meshes;
