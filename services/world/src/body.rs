//! A body: what one is made from, what the world keeps of it, what others may see of it.

use crate::error::WorldError;
use crate::id::BodyId;
use crate::mass::{extents, lever, reach, rounding, sound_inertia};
use crate::material::{Bound, ContactMaterial};
use crate::measure::BodyMeasure;
use crate::motion::Motion;
use crate::path::KeyframedPath;
use crate::settings::Tiers;
use cullet_geometry::{Mat3, Pose, Solid, Vec3};
use std::sync::{Arc, OnceLock};

/// Size class of a body by its volume ratio to the original body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Tier {
    /// Unbreakable; collides as one hull of few corners.
    Tiny,
    /// Unbreakable.
    Small,
    /// Breakable.
    Large,
    /// (Nearly) the original body.
    Whole,
}

impl Tier {
    pub(crate) fn of(ratio: f64, tiers: &Tiers) -> Self {
        if ratio < tiers.tiny {
            Self::Tiny
        } else if ratio < tiers.small {
            Self::Small
        } else if ratio < tiers.large {
            Self::Large
        } else {
            Self::Whole
        }
    }

    /// May a body of this class break?
    #[must_use]
    pub fn breakable(self) -> bool {
        matches!(self, Self::Large | Self::Whole)
    }
}

/// A body to be put into the world.
#[derive(Clone, Debug)]
pub struct BodySpec {
    /// The scene's name for it.
    pub name: String,
    /// Exact shape in the body frame, whose origin is the centre of mass within 1e-9 of the size
    /// \[m\].
    pub solid: Arc<Solid>,
    /// Convex parts that stand in for it in collisions, same frame: corner sets \[m\].
    pub hulls: Vec<Vec<Vec3>>,
    /// What it is made of.
    pub material: ContactMaterial,
    /// Mean density, where it is not the material's: of a body whose volume has changed
    /// \[kg/m³\].
    pub density: Option<f64>,
    /// Body frame to world frame \[m\].
    pub pose: Pose,
    /// Velocity of the centre of mass \[m/s\].
    pub velocity: Vec3,
    /// Angular velocity, world frame \[rad/s\].
    pub spin: Vec3,
    /// Never moves.
    pub fixed: bool,
    /// Moves along this path alone: it pushes others and nothing moves it, as if it were infinitely
    /// heavy. `pose`, `velocity` and `spin` are then taken from the path; it may be neither `fixed`
    /// nor `breakable`.
    pub driven: Option<Arc<KeyframedPath>>,
    /// May hits break it?
    pub breakable: bool,
    /// Least strength anywhere in it over its material's \[1\], flaws apart.
    pub weakest: f64,
    /// Least impulse of a hit \[N·s\]; `None` takes the world's.
    pub threshold: Option<f64>,
    /// The body it broke off from.
    pub parent: Option<BodyId>,
    /// How many fractures it has behind it.
    pub generation: u32,
    /// Volume of the body of the scene that it comes from \[m³\]; `None` for such a body itself.
    pub original_volume: Option<f64>,
}

/// A body as the recorder and the run loop see it.
#[derive(Clone, Copy, Debug)]
pub struct BodyView<'a> {
    /// Its name in this run.
    pub id: BodyId,
    /// The scene's name for it; fragments get their parent's with a number.
    pub name: &'a str,
    /// Exact shape, body frame \[m\].
    pub solid: &'a Arc<Solid>,
    /// What it is made of.
    pub material: &'a ContactMaterial,
    /// Body frame to world frame \[m\].
    pub pose: Pose,
    /// Velocity of the centre of mass \[m/s\].
    pub velocity: Vec3,
    /// Angular velocity, world frame \[rad/s\].
    pub spin: Vec3,
    /// Mass \[kg\].
    pub mass: f64,
    /// Mean density \[kg/m³\].
    pub density: f64,
    /// Volume \[m³\].
    pub volume: f64,
    /// Volume over the original body's \[1\].
    pub volume_ratio: f64,
    /// Least strength anywhere in it over its material's \[1\].
    pub weakest: f64,
    /// Size class.
    pub tier: Tier,
    /// Never moves.
    pub fixed: bool,
    /// Moves along keyframes alone.
    pub driven: bool,
    /// May it break (its tier and generation allow it, and its scene does)?
    pub breakable: bool,
    /// Is it at rest and out of the engine's sight?
    pub sleeping: bool,
    /// The body it broke off from.
    pub parent: Option<BodyId>,
    /// How many fractures it has behind it.
    pub generation: u32,
}

/// How long a striker that goes on through a body may take to pass it \[s\]; what it meets on its
/// way is hit by the same blow.
const PASSAGE: f64 = 0.05;

/// The blow that a fragment broke off in.
#[derive(Clone, Debug)]
pub(crate) struct Blow {
    /// How many blows broke what it comes from, this one counted; 0 for bodies of the scene.
    pub(crate) count: u32,
    /// Who goes on through the body that it was part of: these may hit it at any age (F43).
    pub(crate) strikers: Vec<u32>,
}

/// What the world keeps of a body beside its motion, which the engine holds.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) name: String,
    pub(crate) solid: Arc<Solid>,
    pub(crate) material: ContactMaterial,
    pub(crate) volume: f64,
    pub(crate) original_volume: f64,
    pub(crate) mass: f64,
    /// Mean \[kg/m³\].
    pub(crate) density: f64,
    /// About the centre of mass, body frame \[kg·m²\].
    pub(crate) inertia: Mat3,
    /// Greatest distance of a corner from the centre \[m\].
    pub(crate) reach: f64,
    /// Least extent of the box \[m\].
    pub(crate) thickness: f64,
    pub(crate) fixed: bool,
    pub(crate) driven: Option<Arc<KeyframedPath>>,
    pub(crate) breakable: bool,
    pub(crate) weakest: f64,
    pub(crate) threshold: Option<f64>,
    pub(crate) parent: Option<BodyId>,
    pub(crate) generation: u32,
    pub(crate) tier: Tier,
    /// When it came into the world \[s\]; bodies of the scene are as old as time.
    pub(crate) birth: f64,
    /// The blow that it broke off in.
    pub(crate) blow: Blow,
    /// Its sizes, once they were asked for.
    pub(crate) measure: OnceLock<BodyMeasure>,
}

/// Farthest place a body may be put at \[m\]: f64 still resolves 1e-7 m there.
const FARTHEST: f64 = 1e9;
/// Fastest a body may be \[m/s\]: contact mechanics ends well below.
const FASTEST: f64 = 1e6;
/// How far the centre of mass may be from the origin, in sizes \[1\].
const CENTRE_TOLERANCE: f64 = 1e-9;
/// Most rounding of a body's volume and moments \[1\]: thinner ones have none to speak of.
const MOST_ROUNDING: f64 = 1e-2;
/// Convex parts of one body; more makes the pair search crawl.
const MOST_HULLS: usize = 4096;

impl Body {
    /// Checks a spec and takes its measure. `birth` in \[s\].
    pub(crate) fn new(
        spec: &BodySpec,
        tiers: &Tiers,
        limit: u32,
        birth: f64,
    ) -> Result<Self, WorldError> {
        spec.check()?;
        let m = spec.solid.mesh.mass_properties();
        let reach = reach(&spec.solid.mesh);
        spec.within("volume [m³]", m.volume, f64::MIN_POSITIVE, 1e12)?;
        let rounding = rounding(&spec.solid.mesh, m.volume, reach);
        spec.within("rounding of its thin volume [1]", rounding, 0.0, MOST_ROUNDING)?;
        let (offset, bound) = (m.centroid.norm(), CENTRE_TOLERANCE.max(rounding) * reach);
        if offset > bound {
            return Err(WorldError::OffCentre { name: spec.name.clone(), offset, bound });
        }
        // F32: slivers whose inertia is not positive would spin up for nothing.
        let noise = rounding * reach * reach * m.volume;
        let Some(inertia) = sound_inertia(&m.inertia, noise) else {
            let (what, value) = ("smallest inertia [m⁵]", m.inertia.symmetric_eigenvalues().min());
            let (name, low, high) = (spec.name.clone(), f64::MIN_POSITIVE, f64::MAX);
            return Err(WorldError::OutOfRange { name, what, value, low, high });
        };
        let original_volume = spec.original_volume.unwrap_or(m.volume);
        spec.within("original_volume [m³]", original_volume, f64::MIN_POSITIVE, 1e12)?;
        let tier = Tier::of(m.volume / original_volume, tiers);
        let density = spec.density.unwrap_or(spec.material.solid.density);
        spec.within("density [kg/m³]", density, f64::MIN_POSITIVE, 1e9)?;
        Ok(Self {
            name: spec.name.clone(),
            solid: Arc::clone(&spec.solid),
            material: spec.material,
            volume: m.volume,
            original_volume,
            mass: m.volume * density,
            density,
            inertia: inertia * density,
            reach,
            thickness: extents(spec.solid.mesh.vertices.iter()).min(),
            fixed: spec.fixed,
            driven: spec.driven.clone(),
            breakable: spec.breakable && tier.breakable() && spec.generation < limit,
            weakest: spec.weakest,
            threshold: spec.threshold,
            parent: spec.parent,
            generation: spec.generation,
            tier,
            birth,
            blow: Blow { count: spec.generation, strikers: Vec::new() },
            measure: OnceLock::new(),
        })
    }

    /// Does no contact and no joint move it?
    pub(crate) fn immovable(&self) -> bool {
        self.fixed || self.driven.is_some()
    }

    /// Its sizes, worked out once.
    pub(crate) fn measure(&self) -> &BodyMeasure {
        self.measure.get_or_init(|| {
            let ratio = self.volume / self.original_volume;
            let measure = BodyMeasure::of(&self.solid, self.volume, ratio, self.generation);
            BodyMeasure { weakest: self.weakest, ..measure }
        })
    }

    /// How many blows broke what it comes from, before hits by others, each by whom and when \[s\].
    pub(crate) fn blows_before(&self, hits: impl IntoIterator<Item = (u32, f64)>) -> u32 {
        let mut hits = hits.into_iter().peekable();
        let goes_on = |(other, time): (u32, f64)| {
            self.blow.strikers.contains(&other) && time <= self.birth + PASSAGE
        };
        self.blow.count - u32::from(hits.peek().is_some() && hits.all(goes_on))
    }

    /// Inertia about the centre of mass in the world frame \[kg·m²\].
    pub(crate) fn world_inertia(&self, pose: &Pose) -> Mat3 {
        let r = pose.rotation.to_rotation_matrix();
        r.matrix() * self.inertia * r.matrix().transpose()
    }

    /// How much a unit impulse along `n` at `point` speeds up that point [1/kg]:
    /// 1/m + n·[I⁻¹(r×n)]×r  [Gate 0].
    pub(crate) fn mobility(&self, motion: &Motion, point: &Vec3, n: &Vec3) -> f64 {
        if self.immovable() {
            return 0.0;
        }
        let arm = (point - motion.centre()).cross(n);
        let turn = invert(&self.world_inertia(&motion.pose)) * arm;
        1.0 / self.mass + turn.dot(&arm)
    }
}

/// The inverse of an inertia tensor; the zero matrix where there is none.
pub(crate) fn invert(inertia: &Mat3) -> Mat3 {
    inertia.try_inverse().unwrap_or_else(Mat3::zeros)
}

/// Inertia about a point `r` away from the centre \[kg·m²\].
pub(crate) fn shifted(inertia: &Mat3, mass: f64, r: &Vec3) -> Mat3 {
    inertia + lever(r) * mass
}

impl BodySpec {
    fn within(
        &self,
        what: &'static str,
        value: f64,
        low: f64,
        high: f64,
    ) -> Result<(), WorldError> {
        if (low..=high).contains(&value) {
            return Ok(());
        }
        Err(WorldError::OutOfRange { name: self.name.clone(), what, value, low, high })
    }

    /// Checks its numbers, apart from what its shape comes to.
    ///
    /// # Errors
    /// The first that lies outside its range.
    pub fn check(&self) -> Result<(), WorldError> {
        if let Some(Bound { what, value, low, high }) = self.material.fault() {
            return Err(WorldError::OutOfRange { name: self.name.clone(), what, value, low, high });
        }
        if self.driven.is_some() && (self.fixed || self.breakable) {
            let what = if self.fixed { "fixed" } else { "breakable" };
            return Err(WorldError::Driven { name: self.name.clone(), what });
        }
        let mesh = &self.solid.mesh;
        let corners = mesh.vertices.len();
        let widest = mesh.vertices.iter().map(Vec3::norm).fold(0.0, worse);
        let highest = mesh.triangles.iter().flatten().copied().max().unwrap_or(0);
        self.within("triangles", mesh.triangles.len() as f64, 4.0, 1e8)?;
        self.within("highest corner index", f64::from(highest), 0.0, corners as f64 - 1.0)?;
        self.within("greatest corner distance [m]", widest, f64::MIN_POSITIVE, FARTHEST)?;
        self.within("convex parts", self.hulls.len() as f64, 1.0, MOST_HULLS as f64)?;
        let q = self.pose.rotation.coords.norm();
        self.within(
            "distance from the world's origin [m]",
            norm(&self.pose.translation.vector),
            0.0,
            FARTHEST,
        )?;
        self.within("norm of the orientation quaternion [1]", q, 1.0 - 1e-9, 1.0 + 1e-9)?;
        self.within("speed [m/s]", norm(&self.velocity), 0.0, FASTEST)?;
        self.within("spin [rad/s]", norm(&self.spin), 0.0, FASTEST)?;
        self.within("weakest [1]", self.weakest, f64::MIN_POSITIVE, 1.0)?;
        self.within("threshold [N·s]", self.threshold.unwrap_or(0.0), 0.0, f64::MAX)
    }
}

/// The greater of two, and NaN where one of them is NaN (`f64::max` would lose it).
fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

fn norm(v: &Vec3) -> f64 {
    v.norm()
}
