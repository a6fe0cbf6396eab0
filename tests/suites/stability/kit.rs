//! What the modules of the suite share.

use cullet_geometry::boolean::Exact;
use cullet_geometry::{Solid, TriMesh};

/// Holds a mesh to being a closed, outward solid that the exact kernel takes and that does not
/// cross itself.
pub(crate) fn is_solid(mesh: &TriMesh) {
    assert!(mesh.is_closed(), "{} open or crowded edges", mesh.non_manifold_edges().len());
    let exact = Exact::new(&Solid::outer(mesh.clone())).expect("the kernel takes it");
    assert!(exact.volume() > 0.0, "volume {}", exact.volume());
    assert!(!exact.crosses_itself().expect("it can be asked"), "it crosses itself");
}
