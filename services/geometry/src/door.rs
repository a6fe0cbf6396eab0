//! Admission of a raw mesh: checked, and repaired or refused by name.

mod crossing;
mod holes;
mod open;
mod remesh;
mod shells;
mod topology;

pub use open::{admit_open, near_miss};

use crate::boolean::{BooleanError, Exact, rebuild};
use crate::inside::Nearest;
use crate::math::Vec3;
use crate::mesh::{MeshError, Solid, TriMesh};

/// Most triangles admitted; at this size, repair takes about a minute.
pub const MAX_TRIANGLES: usize = 5_000_000;
/// Diagonals admitted \[m\]: outside, products of lengths and densities lose digits in f64.
pub const DIAGONALS: (f64, f64) = (1e-7, 1e6);
/// Open edges whose ends are closer than this share of the diagonal are sewn together; about the
/// precision of coordinates in text files.
const SEWING: f64 = 1e-6;
/// Most triangles that the exact rebuild is tried on: it takes about a second per 10 000.
const MAX_REBUILD: usize = 300_000;

/// What to do with a mesh that is not a clean solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Repair {
    /// Make it one, and report how.
    Auto,
    /// Refuse it by name.
    Refuse,
}

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
    /// Triangles in the end.
    pub triangles: usize,
    /// Enclosed volume in the end \[m³\].
    pub volume: f64,
}

/// Why a mesh was not admitted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DoorError {
    /// The arrays are wrong.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// Too many triangles.
    #[error("the mesh has {triangles} triangles; at most {MAX_TRIANGLES} are accepted")]
    TooMany {
        /// How many it has.
        triangles: usize,
    },
    /// Too small or too large.
    #[error(
        "the mesh is {diagonal:e} m across; {:e} to {:e} m are taken",
        DIAGONALS.0,
        DIAGONALS.1
    )]
    Size {
        /// Its diagonal \[m\].
        diagonal: f64,
    },
    /// Triangles without area.
    #[error("{count} triangles have no area, the first is triangle {first}")]
    Degenerate {
        /// How many there are.
        count: usize,
        /// The first.
        first: usize,
    },
    /// Triangles with the same three corners.
    #[error("{count} triangles have the corners of another, the first is triangle {first}")]
    Duplicate {
        /// How many there are.
        count: usize,
        /// The first.
        first: usize,
    },
    /// Edges with one triangle: the mesh has holes.
    #[error("{count} edges are open, the first at {}", place(first))]
    OpenEdges {
        /// How many there are.
        count: usize,
        /// Middle of the first \[m\].
        first: Vec3,
    },
    /// Edges with more than two triangles.
    #[error("{count} edges have more than two triangles, the first at {}", place(first))]
    NonManifold {
        /// How many there are.
        count: usize,
        /// Middle of the first \[m\].
        first: Vec3,
    },
    /// Neighbouring triangles that face opposite ways.
    #[error("{count} edges have triangles that face opposite ways, the first at {}", place(first))]
    NotOriented {
        /// How many there are.
        count: usize,
        /// Middle of the first \[m\].
        first: Vec3,
    },
    /// A closed shell faces inward where it should face outward, or lies inside another.
    #[error("shell {shell} of {shells} ({volume:e} m³) is inside out or in another")]
    Inverted {
        /// Which, in order of first triangle.
        shell: usize,
        /// Of how many.
        shells: usize,
        /// Its signed volume \[m³\].
        volume: f64,
    },
    /// The surface crosses or touches itself.
    #[error("at least {count} pairs of triangles cross, the first near {}", place(first))]
    SelfIntersecting {
        /// Pairs found (at least 1).
        count: usize,
        /// Where the first is \[m\].
        first: Vec3,
    },
    /// Nothing solid is left.
    #[error("the mesh encloses no volume")]
    NoVolume,
    /// What is left is thinner than rounding lets a body be.
    #[error(
        "the mesh encloses no volume to speak of: {volume:.3e} m³; a shell as large must have at \
         least {least:.3e} m³"
    )]
    Thin {
        /// Its volume \[m³\].
        volume: f64,
        /// Least accepted: a share of its diagonal cubed \[m³\].
        least: f64,
    },
    /// Every way of repair failed; this is the last failure.
    #[error("the mesh could not be repaired: {0}")]
    Unrepairable(BooleanError),
}

/// Checks a mesh and gives back a closed, outward-oriented one that does not cross itself and that
/// [`Exact::new`] accepts, with a report of what was done to it. Equal vertices are merged, unless
/// the mesh is closed without that.
///
/// # Errors
/// With [`Repair::Refuse`], the first defect found; with [`Repair::Auto`], only what cannot be
/// repaired: wrong arrays, an impossible size, no volume.
pub fn admit(mesh: &TriMesh, repair: Repair) -> Result<(TriMesh, RepairReport), DoorError> {
    check_count(mesh)?;
    let mut report = RepairReport::default();
    let (welded, merged) = if mesh.is_closed() { (mesh.clone(), 0) } else { topology::weld(mesh) };
    let diagonal = welded.diagonal();
    if !(DIAGONALS.0..=DIAGONALS.1).contains(&diagonal) {
        return Err(DoorError::Size { diagonal });
    }
    report.merged_vertices = merged;
    let admitted = match repair {
        Repair::Refuse => checked(welded)?,
        Repair::Auto => mended(welded, &mut report)?,
    };
    report.triangles = admitted.triangles.len();
    report.volume = admitted.signed_volume();
    Ok((admitted, report))
}

/// Refuses wrong arrays, no triangles and too many.
fn check_count(mesh: &TriMesh) -> Result<(), DoorError> {
    mesh.validate()?;
    let triangles = mesh.triangles.len();
    if triangles == 0 {
        return Err(MeshError::Empty { vertices: mesh.vertices.len() }.into());
    }
    if triangles > MAX_TRIANGLES {
        return Err(DoorError::TooMany { triangles });
    }
    Ok(())
}

/// Looks for every defect in turn.
fn checked(mesh: TriMesh) -> Result<TriMesh, DoorError> {
    check_faces(&mesh)?;
    let open = mesh.edges();
    let mut open = open.iter().filter(|e| e.forward + e.backward == 1);
    if let Some(first) = open.next() {
        return Err(DoorError::OpenEdges { count: 1 + open.count(), first: middle(&mesh, first) });
    }
    check_edges(&mesh)?;
    shells::check(&mesh)?;
    let exact = import(&mesh)?;
    if exact.crosses_itself().map_err(DoorError::Unrepairable)? {
        let (count, first) = crossing::count(&mesh);
        return Err(DoorError::SelfIntersecting { count, first });
    }
    Ok(mesh)
}

/// Refuses triangles without area, and such as are there twice.
fn check_faces(mesh: &TriMesh) -> Result<(), DoorError> {
    let listed = |found: &[usize]| found.first().map(|&first| (found.len(), first));
    if let Some((count, first)) = listed(&topology::flat(mesh)) {
        return Err(DoorError::Degenerate { count, first });
    }
    if let Some((count, first)) = listed(&topology::repeated(mesh)) {
        return Err(DoorError::Duplicate { count, first });
    }
    Ok(())
}

/// Refuses edges with more than two triangles, or with two that face opposite ways.
fn check_edges(mesh: &TriMesh) -> Result<(), DoorError> {
    let edges = mesh.edges();
    let bad = |test: &dyn Fn(u32, u32) -> bool| {
        let mut found = edges.iter().filter(|e| test(e.forward, e.backward));
        found.next().map(|first| (1 + found.count(), middle(mesh, first)))
    };
    if let Some((count, first)) = bad(&|f, b| f + b > 2) {
        return Err(DoorError::NonManifold { count, first });
    }
    if let Some((count, first)) = bad(&|f, b| f + b == 2 && f != b) {
        return Err(DoorError::NotOriented { count, first });
    }
    Ok(())
}

fn middle(mesh: &TriMesh, edge: &crate::mesh::EdgeUse) -> Vec3 {
    0.5 * (mesh.vertices[edge.from as usize] + mesh.vertices[edge.to as usize])
}

/// Repairs step by step, each step only where the one before left a defect.
fn mended(mut mesh: TriMesh, report: &mut RepairReport) -> Result<TriMesh, DoorError> {
    let original = mesh.clone();
    topology::drop_collapsed(&mut mesh, report);
    topology::cancel_repeated(&mut mesh, report);
    if !topology::is_balanced(&mesh) {
        topology::drop_flat(&mut mesh, report);
        topology::sew(&mut mesh, SEWING * original.diagonal(), report);
        topology::drop_collapsed(&mut mesh, report);
        topology::cancel_repeated(&mut mesh, report);
        holes::divide_at_junctions(&mut mesh, SEWING * original.diagonal(), report);
        topology::orient(&mut mesh, report);
        holes::fill(&mut mesh, report);
    }
    mesh = topology::compacted(&mesh);
    if mesh.triangles.is_empty() {
        return Err(DoorError::NoVolume);
    }
    if !topology::is_balanced(&mesh) {
        return remeshed(&original, report);
    }
    let (volume, least) = (mesh.signed_volume().abs(), shells::least_volume(&mesh));
    mesh = shells::ordered(&mesh, report);
    if mesh.triangles.is_empty() {
        let none = volume == 0.0;
        return Err(if none { DoorError::NoVolume } else { DoorError::Thin { volume, least } });
    }
    report.crowded_edges = mesh.non_manifold_edges().len();
    match untangled(&mesh, report) {
        Ok(clean) => Ok(clean),
        Err(_) => remeshed(&original, report),
    }
}

/// A balanced mesh as a closed one without crossings.
fn untangled(mesh: &TriMesh, report: &mut RepairReport) -> Result<TriMesh, DoorError> {
    let exact = import(mesh)?;
    if !exact.crosses_itself().map_err(DoorError::Unrepairable)? {
        if mesh.is_closed() {
            return Ok(mesh.clone());
        }
        return proven(&exact);
    }
    if mesh.triangles.len() > MAX_REBUILD {
        let (count, first) = crossing::count(mesh);
        return Err(DoorError::SelfIntersecting { count, first });
    }
    let rebuilt = proven(&rebuild(mesh).map_err(DoorError::Unrepairable)?)?;
    report.merged_shells = true;
    Ok(rebuilt)
}

/// The mesh of an exact solid, if the kernel takes it back and finds nothing to complain of.
fn proven(exact: &Exact) -> Result<TriMesh, DoorError> {
    let mesh = exact.to_solid().map_err(DoorError::Unrepairable)?.mesh;
    let again = import(&mesh)?;
    if again.crosses_itself().map_err(DoorError::Unrepairable)? {
        let (count, first) = crossing::count(&mesh);
        return Err(DoorError::SelfIntersecting { count, first });
    }
    Ok(mesh)
}

/// The last resort: a new surface from the distance to the old one. A grid that happens to fit
/// the surface's own planes can fold it by a rounding error; then the next is tried.
fn remeshed(original: &TriMesh, report: &mut RepairReport) -> Result<TriMesh, DoorError> {
    let mut last = DoorError::NoVolume;
    for edges in remesh::GRIDS {
        let (exact, edge) =
            remesh::from_distance(original, edges).map_err(DoorError::Unrepairable)?;
        if exact.is_empty() {
            return Err(DoorError::NoVolume);
        }
        let unfolded = |e| rebuild(&exact.mesh()).map_err(|_| e).and_then(|r| proven(&r));
        match proven(&exact).or_else(unfolded) {
            Ok(mesh) => {
                let surface = Nearest::new(&mesh);
                let distances = original.vertices.iter().map(|&p| surface.distance(p));
                report.moved = distances.fold(0.0, f64::max);
                report.remeshed = edge;
                return Ok(mesh);
            }
            Err(e) => last = e,
        }
    }
    Err(last)
}

/// A point as an error message shows it.
fn place(p: &Vec3) -> String {
    format!("({:.6}, {:.6}, {:.6})", p.x, p.y, p.z)
}

fn import(mesh: &TriMesh) -> Result<Exact, DoorError> {
    Exact::new(&Solid::outer(mesh.clone())).map_err(|e| match e {
        BooleanError::NotSolid { .. } => DoorError::NoVolume,
        other => DoorError::Unrepairable(other),
    })
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
            parts.push("crossing shells merged".to_owned());
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

#[cfg(test)]
mod tests;
