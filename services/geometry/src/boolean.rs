//! Exact boolean operations on closed bodies: the one file that names the boolean kernel.
//!
//! The kernel works to 1e-12 of a body's size and keeps, for each face it makes, the face it was
//! cut from. That is where a face's tag travels, or the bits of its damage time *as* the kernel's
//! face id, so no table has to follow, however many cuts come after. The kernel
//! answers bad input with silence (an open mesh becomes an empty one), so every import and every
//! operation here is followed by a question about its status.

mod half_space;

use crate::inside::Inside;
use crate::math::Vec3;
use crate::mesh::{MeshError, Solid, Surface, TriMesh};
use half_space::half_space;
use manifold_rust::linalg::Vec3 as KernelVec;
use manifold_rust::manifold::Manifold;
use manifold_rust::types::{Box as KernelBox, Error as KernelError, MeshGLP, OpType, WindingRule};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Face id of [`Surface::Outer`]; the bits of a NaN, so never those of a damage time.
const OUTER_ID: u32 = MAX_TAG;

/// The greatest tag of a triangle: the kernel reads one with a sign bit as absent.
pub const MAX_TAG: u32 = i32::MAX as u32;

/// Why the kernel did not take a solid or give one back.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BooleanError {
    /// The arrays of the solid are wrong.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The mesh is not closed.
    #[error(
        "not closed: {open} open, {crowded} crowded or misdirected edges, the first at {first}"
    )]
    NotClosed {
        /// Edges that one triangle uses.
        open: usize,
        /// Edges used more than twice, or twice in one direction.
        crowded: usize,
        /// A vertex of the first such edge, as coordinates \[m\].
        first: String,
    },
    /// The mesh encloses no volume or is inside out.
    #[error("the mesh encloses {volume:.3e} m³; it must be positive")]
    NotSolid {
        /// Its signed volume \[m³\].
        volume: f64,
    },
    /// The direction of a plane is zero or not finite, or its offset is not finite.
    #[error("a plane needs a finite direction and offset, not ({x}, {y}, {z}) and {offset}")]
    Plane {
        /// The direction given.
        x: f64,
        /// The direction given.
        y: f64,
        /// The direction given.
        z: f64,
        /// The offset given.
        offset: f64,
    },
    /// The kernel refused.
    #[error("{operation}: the boolean kernel says \"{status}\"")]
    Kernel {
        /// What was asked of it.
        operation: &'static str,
        /// Its answer.
        status: String,
    },
    /// The kernel panicked.
    #[error("{operation}: the boolean kernel panicked")]
    Panicked {
        /// What was asked of it.
        operation: &'static str,
    },
}

/// A solid that the exact boolean kernel has accepted. Keeps each face's tag, or whether it is a
/// crack and when it opened, through every operation.
#[derive(Clone)]
pub struct Exact(Manifold);

impl std::fmt::Debug for Exact {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Exact").field("triangles", &self.0.num_tri()).finish_non_exhaustive()
    }
}

impl Exact {
    /// Hands a closed, outward-oriented solid to the kernel, of a crack face only the damage time
    /// at its first corner: for more, see [`Exact::tagged`]. Edges with four or more triangles are
    /// taken apart, as long as they are used as often one way as the other.
    ///
    /// # Errors
    /// [`BooleanError::Mesh`], [`BooleanError::NotClosed`], [`BooleanError::NotSolid`], or the
    /// kernel's own refusal.
    pub fn new(solid: &Solid) -> Result<Self, BooleanError> {
        solid.validate()?;
        let tags: Vec<u32> = solid.surface.iter().map(|&s| id_of(s)).collect();
        Self::tagged(&solid.mesh, &tags)
    }

    /// As [`Exact::new`], with a tag of the caller's for each triangle in place of its surface; a
    /// triangle made from it, by any operation, has the same tag. Tags are at most [`MAX_TAG`].
    ///
    /// # Errors
    /// As [`Exact::new`]; a mesh without one tag a triangle, or with a greater one.
    pub fn tagged(mesh: &TriMesh, tags: &[u32]) -> Result<Self, BooleanError> {
        mesh.validate()?;
        let (surfaces, triangles) = (tags.len(), mesh.triangles.len());
        if surfaces != triangles || tags.iter().any(|&tag| tag > MAX_TAG) {
            return Err(MeshError::SurfaceLength { surfaces, triangles }.into());
        }
        if mesh.triangles.is_empty() {
            return Err(MeshError::Empty { vertices: mesh.vertices.len() }.into());
        }
        closed(mesh, |forward, backward| forward == backward)?;
        let volume = mesh.signed_volume();
        if volume.is_nan() || volume <= 0.0 {
            return Err(BooleanError::NotSolid { volume });
        }
        let accepted = run("import", || Manifold::from_mesh_glp(&to_kernel(mesh, tags)))?;
        if accepted.0.is_empty() {
            return Err(BooleanError::NotSolid { volume });
        }
        Ok(accepted)
    }

    /// The part of space in both. May be empty.
    ///
    /// # Errors
    /// The kernel's refusal or panic.
    pub fn intersect(&self, other: &Self) -> Result<Self, BooleanError> {
        if self.apart(other) {
            return Ok(Self(Manifold::empty()));
        }
        run("intersection", || self.0.boolean(&other.0, OpType::Intersect))
    }

    /// The part of `self` that is not in `other`. May be empty.
    ///
    /// # Errors
    /// The kernel's refusal or panic.
    pub fn subtract(&self, other: &Self) -> Result<Self, BooleanError> {
        if self.apart(other) {
            return Ok(self.clone());
        }
        run("difference", || self.0.boolean(&other.0, OpType::Subtract))
    }

    /// The part of space in either.
    ///
    /// # Errors
    /// The kernel's refusal or panic.
    pub fn union(&self, other: &Self) -> Result<Self, BooleanError> {
        run("union", || self.0.boolean(&other.0, OpType::Add))
    }

    /// The part where `normal · x > offset` \[m, for a unit normal\] and the other part. Either may
    /// be empty. The caps are [`Surface::Crack`] with damage time zero: a plane cut has no time.
    ///
    /// # Errors
    /// [`BooleanError::Plane`], or the kernel's refusal.
    pub fn split(&self, normal: Vec3, offset: f64) -> Result<(Self, Self), BooleanError> {
        let length = normal.norm();
        if !(length.is_finite() && length > 0.0 && offset.is_finite()) {
            return Err(BooleanError::Plane { x: normal.x, y: normal.y, z: normal.z, offset });
        }
        let Some((low, high)) = self.bounds() else {
            return Ok((self.clone(), self.clone()));
        };
        let (unit, offset) = (normal / length, offset / length);
        let middle = 0.5 * (low + high);
        let reach = 0.5 * (high - low).norm();
        let height = unit.dot(&middle) - offset;
        if height.abs() > reach {
            let none = Self(Manifold::empty());
            return Ok(if height > 0.0 { (self.clone(), none) } else { (none, self.clone()) });
        }
        let half = Self::new(&half_space(unit, middle - height * unit, reach))?;
        Ok((self.intersect(&half)?, self.subtract(&half)?))
    }

    /// The connected parts, by falling volume, then by position. A cavity stays with the part
    /// around it; parts without volume are dropped.
    ///
    /// # Errors
    /// The kernel's refusal or panic.
    pub fn components(&self) -> Result<Vec<Self>, BooleanError> {
        let shells = guard("decomposition", || self.0.decompose())?;
        if shells.len() <= 1 {
            return Ok(if self.is_empty() { Vec::new() } else { vec![self.clone()] });
        }
        let (mut parts, mut cavities) = (Vec::new(), Vec::new());
        for shell in shells {
            let shell = accepted("decomposition", shell)?;
            let volume = shell.volume();
            if volume > 0.0 {
                parts.push((volume, shell));
            } else if volume < 0.0 {
                cavities.push(shell);
            }
        }
        parts
            .sort_by(|(a, p), (b, q)| b.total_cmp(a).then_with(|| p.place().total_cmp(&q.place())));
        let mut parts: Vec<Self> = parts.into_iter().map(|(_, p)| p).collect();
        fill_cavities(&mut parts, &cavities)?;
        Ok(parts)
    }

    /// Whether nothing is left.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Enclosed volume \[m³\].
    #[must_use]
    pub fn volume(&self) -> f64 {
        self.mesh().signed_volume()
    }

    /// Least and greatest corner of the axis-aligned box around it \[m\]; `None` if empty.
    #[must_use]
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        if self.is_empty() {
            return None;
        }
        let b = self.0.bounding_box();
        Some((from_kernel(b.min), from_kernel(b.max)))
    }

    /// The boundary without the origin of its faces, in the kernel's order; empty if nothing is
    /// left.
    #[must_use]
    pub fn mesh(&self) -> TriMesh {
        let body = self.0.as_impl();
        let vertices = body.vert_pos.iter().map(|&p| from_kernel(p)).collect();
        let corners = body.halfedge.chunks_exact(3);
        let triangles = corners.map(|h| [0, 1, 2].map(|i| h[i].start_vert as u32)).collect();
        TriMesh { vertices, triangles }
    }

    /// The closed, index-connected boundary with the [`Surface`] of each triangle. Triangles come
    /// in a fixed order, each from its smallest vertex. An empty body gives an empty solid.
    ///
    /// # Errors
    /// [`BooleanError::NotClosed`] if the kernel broke its promise.
    pub fn to_solid(&self) -> Result<Solid, BooleanError> {
        let (mesh, tags) = self.to_tagged()?;
        Ok(Solid { mesh, surface: tags.into_iter().map(surface_of).collect() })
    }

    /// As [`Exact::to_solid`], with the tag of each triangle.
    ///
    /// # Errors
    /// [`BooleanError::NotClosed`] if the kernel broke its promise.
    pub fn to_tagged(&self) -> Result<(TriMesh, Vec<u32>), BooleanError> {
        let (mesh, tags) = self.export();
        if !mesh.triangles.is_empty() {
            closed(&mesh, |forward, backward| forward == 1 && backward == 1)?;
        }
        Ok((mesh, tags))
    }

    /// Whether two of its triangles cross or lie on each other, which the exact operations assume
    /// not to be.
    ///
    /// # Errors
    /// The kernel's panic.
    pub fn crosses_itself(&self) -> Result<bool, BooleanError> {
        guard("self-intersection test", || self.0.has_self_intersections())
    }

    fn apart(&self, other: &Self) -> bool {
        match (self.bounds(), other.bounds()) {
            (Some((a, b)), Some((c, d))) => (0..3).any(|i| b[i] < c[i] || d[i] < a[i]),
            _ => true,
        }
    }

    /// A number that tells bodies of equal volume apart \[m\].
    fn place(&self) -> f64 {
        self.bounds().map_or(0.0, |(low, _)| low.x + 1.618 * low.y + 2.236 * low.z)
    }

    fn export(&self) -> (TriMesh, Vec<u32>) {
        let out: MeshGLP<f64, u32> = self.0.get_mesh_glp(-1);
        let vertices = out.vert_properties.chunks_exact(3).map(|p| Vec3::new(p[0], p[1], p[2]));
        let mut faces: Vec<([u32; 3], u32)> = out
            .tri_verts
            .chunks_exact(3)
            .zip(&out.face_id)
            .map(|(t, &id)| (from_smallest([t[0], t[1], t[2]]), id))
            .collect();
        faces.sort_unstable();
        let (triangles, tags) = faces.into_iter().unzip();
        (TriMesh { vertices: vertices.collect(), triangles }, tags)
    }
}

/// Rebuilds a closed but crossing, doubled or partly inside-out surface as the boundary of the
/// space that it winds around, with exact rational arithmetic. Slow: for repair only.
///
/// # Errors
/// [`BooleanError::Kernel`] for a surface that is not closed, or the kernel's panic.
pub fn rebuild(mesh: &TriMesh) -> Result<Exact, BooleanError> {
    mesh.validate()?;
    run("rebuild", || {
        let soup = Manifold::from_mesh_glp_robust(&outer(mesh));
        if soup.status() == KernelError::NoError {
            soup.rebuild_solid(WindingRule::Nonzero)
        } else {
            soup
        }
    })
}

/// The surface where `field` (positive inside) is zero, from a body-centred grid of `edge` \[m\]
/// inside the box from `low` to `high` \[m\]. Always closed.
///
/// # Errors
/// The kernel's refusal or panic.
pub fn level_set(
    field: impl Fn(Vec3) -> f64 + Sync,
    low: Vec3,
    high: Vec3,
    edge: f64,
) -> Result<Exact, BooleanError> {
    run("level set", || {
        let bounds = KernelBox { min: into_kernel(low), max: into_kernel(high) };
        let raw = Manifold::level_set(|p| field(from_kernel(p)), bounds, edge);
        if raw.status() != KernelError::NoError {
            return raw;
        }
        Manifold::from_mesh_glp(&outer(&Exact(raw).export().0))
    })
}

/// Runs a kernel call, turning a panic into an error.
fn guard<T>(operation: &'static str, call: impl FnOnce() -> T) -> Result<T, BooleanError> {
    catch_unwind(AssertUnwindSafe(call)).map_err(|_| BooleanError::Panicked { operation })
}

/// Runs a kernel call that makes a body, and asks how it went.
fn run(operation: &'static str, call: impl FnOnce() -> Manifold) -> Result<Exact, BooleanError> {
    accepted(operation, guard(operation, call)?)
}

fn accepted(operation: &'static str, body: Manifold) -> Result<Exact, BooleanError> {
    match body.status() {
        KernelError::NoError => Ok(Exact(body)),
        status => Err(BooleanError::Kernel { operation, status: status.to_string() }),
    }
}

/// Gives each inside-out shell to the smallest part around it. `parts` fall in volume.
fn fill_cavities(parts: &mut [Exact], cavities: &[Exact]) -> Result<(), BooleanError> {
    let tests: Vec<Inside> = if cavities.is_empty() {
        Vec::new()
    } else {
        parts.iter().map(|p| Inside::new(&p.mesh())).collect()
    };
    let mut holes: Vec<Vec<&Exact>> = vec![Vec::new(); parts.len()];
    for cavity in cavities {
        let Some(&corner) = cavity.mesh().vertices.first() else {
            continue;
        };
        if let Some(home) = tests.iter().rposition(|t| t.contains(corner)) {
            holes[home].push(cavity);
        }
    }
    for (part, holes) in parts.iter_mut().zip(holes).filter(|(_, h)| !h.is_empty()) {
        let mut shells = vec![part.0.clone()];
        shells.extend(holes.iter().map(|h| h.0.clone()));
        *part = run("composition", || Manifold::compose(&shells))?;
    }
    Ok(())
}

/// Reports the edges whose uses (forward, backward) are not right, if there are any.
fn closed(mesh: &TriMesh, right: impl Fn(u32, u32) -> bool) -> Result<(), BooleanError> {
    let bad: Vec<_> = mesh.edges().into_iter().filter(|e| !right(e.forward, e.backward)).collect();
    let Some(first) = bad.first() else {
        return Ok(());
    };
    let open = bad.iter().filter(|e| e.forward + e.backward == 1).count();
    let p = mesh.vertices[first.from as usize];
    let first = format!("({:.6}, {:.6}, {:.6})", p.x, p.y, p.z);
    Err(BooleanError::NotClosed { open, crowded: bad.len() - open, first })
}

fn outer(mesh: &TriMesh) -> MeshGLP<f64, u32> {
    to_kernel(mesh, &vec![OUTER_ID; mesh.triangles.len()])
}

fn to_kernel(mesh: &TriMesh, tags: &[u32]) -> MeshGLP<f64, u32> {
    MeshGLP {
        num_prop: 3,
        vert_properties: mesh.vertices.iter().flat_map(|p| [p.x, p.y, p.z]).collect(),
        tri_verts: mesh.triangles.iter().flatten().copied().collect(),
        face_id: tags.to_vec(),
        run_original_id: vec![0],
        ..Default::default()
    }
}

fn into_kernel(p: Vec3) -> KernelVec {
    KernelVec::new(p.x, p.y, p.z)
}

fn from_kernel(p: KernelVec) -> Vec3 {
    Vec3::new(p.x, p.y, p.z)
}

/// A face id without sign bit; the kernel reads one with it as absent.
fn id_of(surface: Surface) -> u32 {
    match surface {
        Surface::Outer => OUTER_ID,
        Surface::Crack { damage_time, .. } => damage_time[0].abs().to_bits(),
    }
}

fn surface_of(id: u32) -> Surface {
    if id == OUTER_ID { Surface::Outer } else { Surface::crack(f32::from_bits(id)) }
}

/// The same triangle, starting from its smallest index.
fn from_smallest([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

#[cfg(test)]
mod tests;
