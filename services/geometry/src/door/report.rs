//! What the repair of a mesh did.

use crate::math::Vec3;

/// What repair did. All zero for a clean mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RepairReport {
    /// Vertices merged into another: equal ones, and near ones along open edges.
    pub merged_vertices: usize,
    /// Triangles dropped because they have no area.
    pub degenerate: usize,
    /// Triangles dropped because another has the same corners.
    pub duplicates: usize,
    /// Triangles divided at a corner of a neighbour that lay on their edge.
    pub junctions: usize,
    /// Triangles turned over.
    pub flipped: usize,
    /// Holes closed.
    pub holes: usize,
    /// Open edges that those holes had.
    pub hole_edges: usize,
    /// Width of the widest hole \[m\].
    pub widest_hole: f64,
    /// Shells dropped: flat, or wholly inside another.
    pub dropped_shells: usize,
    /// Edges with more than two triangles, taken apart.
    pub crowded_edges: usize,
    /// Whether shells that crossed were merged into one surface.
    pub merged_shells: bool,
    /// Edge length of the grid \[m\] from which the surface was made anew; zero if it was not.
    pub remeshed: f64,
    /// Farthest that the surface moved \[m\].
    pub moved: f64,
    /// Where it moved farthest when it was made anew \[m\].
    pub moved_most_at: Vec3,
    /// Triangles in the end.
    pub triangles: usize,
    /// Enclosed volume in the end \[m³\].
    pub volume: f64,
}

impl RepairReport {
    /// Whether the mesh came through unchanged but for merged equal vertices.
    #[must_use]
    pub fn is_clean(&self) -> bool {
        let (merged_vertices, triangles, volume) =
            (self.merged_vertices, self.triangles, self.volume);
        *self == Self { merged_vertices, triangles, volume, ..Self::default() }
    }
}

impl std::fmt::Display for RepairReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let counted = [
            (self.merged_vertices, "vertices merged"),
            (self.degenerate, "triangles without area dropped"),
            (self.duplicates, "repeated triangles dropped"),
            (self.junctions, "triangles divided at T-junctions"),
            (self.flipped, "triangles turned over"),
            (self.dropped_shells, "flat or swallowed shells dropped"),
            (self.crowded_edges, "crowded edges taken apart"),
        ];
        let mut parts: Vec<String> =
            counted.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")).collect();
        if self.holes > 0 {
            parts.push(format!(
                "{} holes of {} open edges closed, the widest {:.3e} m",
                self.holes, self.hole_edges, self.widest_hole
            ));
        }
        if self.merged_shells {
            parts.push("touching or crossing shells joined".to_owned());
        }
        if self.remeshed > 0.0 {
            parts.push(format!("surface made anew on a grid of {:.3e} m", self.remeshed));
        }
        if self.moved > 0.0 {
            parts.push(format!("surface moved by up to {:.3e} m", self.moved));
        }
        if parts.is_empty() {
            parts.push("nothing to repair".to_owned());
        }
        write!(f, "{} ({} triangles, {:.4e} m³)", parts.join("; "), self.triangles, self.volume)
    }
}
