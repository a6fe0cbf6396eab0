//! Bodies that are simulated for as long as a scene lasts: what a window of their time gets and
//! gives.
//!
//! Simulated time is cut into windows of some steps of the rigid world. A window is a pure
//! function: from what the body is, its state, and the rigid bodies in its reach, to its next state
//! and what it gave to those bodies. The rigid bodies stand in a window with their mass and
//! inertia, so that forces go both ways inside it; between windows only the places of bodies that
//! met another rigid body lag, and the caller looks at that gap.

use crate::membrane::MembraneSheet;
use crate::outcome::Figure;
use crate::refusal::{Failure, Refusal};
use crate::soft::{SoftBody, SoftLaw};
use cullet_geometry::{Mat3, Pose, Solid, Vec3};
use std::any::Any;
use std::sync::Arc;

/// What a body that moves as it deforms is, before anything happens.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum ContinuumBody {
    /// A thin sheet.
    Membrane(MembraneSheet),
    /// A soft shell or a soft solid.
    Soft(SoftBody),
}

impl ContinuumBody {
    /// Name of the family that solves it.
    #[must_use]
    pub fn family(&self) -> &'static str {
        match self {
            Self::Membrane(_) => "membrane",
            Self::Soft(SoftBody { law: SoftLaw::Shell { .. }, .. }) => "soft-shell",
            Self::Soft(SoftBody { law: SoftLaw::Bonded(_), .. }) => "soft-solid",
        }
    }

    /// Corners that span it at rest, in the world \[m\].
    #[must_use]
    pub fn corners(&self) -> Vec<Vec3> {
        match self {
            Self::Membrane(sheet) => {
                let place = |at: &[f64; 2]| nalgebra::Point3::new(at[0], at[1], 0.0);
                sheet.outline.iter().map(|at| (sheet.pose * place(at)).coords).collect()
            }
            Self::Soft(body) => {
                let place = |at: &Vec3| (body.pose * nalgebra::Point3::from(*at)).coords;
                body.solid.mesh.vertices.iter().map(place).collect()
            }
        }
    }

    /// Whether its windows say of which object of the scene each rigid body is.
    #[must_use]
    pub fn asks_for_objects(&self) -> bool {
        match self {
            Self::Membrane(sheet) => sheet.diffusion.asks_for_objects(),
            Self::Soft(_) => false,
        }
    }

    /// Speed of the fastest of its points at first \[m/s\].
    #[must_use]
    pub fn speed(&self) -> f64 {
        match self {
            Self::Membrane(sheet) => sheet.velocity.norm(),
            Self::Soft(body) => {
                let reaches = body.solid.mesh.vertices.iter().map(nalgebra::Matrix::norm);
                body.velocity.norm() + body.spin.norm() * reaches.fold(0.0, f64::max)
            }
        }
    }

    /// Distance of its points \[m\].
    #[must_use]
    pub fn spacing(&self) -> f64 {
        match self {
            Self::Membrane(sheet) => sheet.spacing,
            Self::Soft(body) => body.spacing,
        }
    }
}

/// A body and the clock that it is simulated by: all that stays the same from window to window.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct ContinuumSetup {
    /// The body.
    pub body: ContinuumBody,
    /// Step of the rigid world \[s\].
    pub world_step: f64,
    /// Acceleration of free fall \[m/s²\].
    pub gravity: Vec3,
    /// For places of points and scatter of strength.
    pub seed: u64,
}

/// A stretch of time that is simulated at once.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Window {
    /// Steps of the rigid world before it.
    pub first_step: u64,
    /// Steps of the rigid world in it.
    pub steps: u32,
    /// A frame is wanted after each step whose number is a multiple of this.
    pub frame_every: u32,
    /// Rigid bodies in reach, by rising number.
    pub proxies: Vec<Proxy>,
    /// Pieces that have become rigid bodies since the last window, by number: they are here no
    /// more. `None`: none shall.
    pub retired: Option<Vec<u32>>,
}

/// A rigid body as it stands in a window.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Proxy {
    /// Its number in the world.
    pub body: u64,
    /// Number of the object of the scene that it is or came from, where the deforming body asks
    /// for it. It travels beside the numbers.
    #[cfg_attr(feature = "wire", serde(skip))]
    pub object: Option<u32>,
    /// Corners of its convex parts in its own frame, which has its centre of mass as origin \[m\].
    /// They travel beside the numbers.
    #[cfg_attr(feature = "wire", serde(skip))]
    pub parts: Vec<Vec<Vec3>>,
    /// Coulomb's coefficient against the deforming body \[1\].
    pub friction: f64,
    /// Where it is as the window begins.
    pub pose: Pose,
    /// Of its centre \[m/s\].
    pub velocity: Vec3,
    /// \[rad/s\].
    pub spin: Vec3,
    /// What moves it.
    pub motion: ProxyMotion,
}

/// What moves a rigid body in a window.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum ProxyMotion {
    /// Its inertia, gravity, and what the deforming body does to it.
    Free {
        /// \[kg\].
        mass: f64,
        /// About its centre, in its own frame \[kg·m²\].
        inertia: Mat3,
    },
    /// It keeps the velocity and spin that it has, whatever touches it: zero for a fixed one.
    Steady,
    /// It is at these poses after each step of the world.
    Led(
        // They travel beside the numbers.
        #[cfg_attr(feature = "wire", serde(skip))] Vec<Pose>,
    ),
}

/// What a rigid body was given in a window.
#[derive(Clone, Debug, PartialEq)]
pub struct Handed {
    /// Its number in the world.
    pub body: u64,
    /// In each step of the world, the impulse \[N·s\] and its moment about the body's centre
    /// \[N·m·s\].
    pub impulses: Vec<[Vec3; 2]>,
    /// Where the window has it after each step of the world.
    pub poses: Vec<Pose>,
}

/// Where a deforming body is, and how fast it moves: what says which rigid bodies it may meet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct SweptExtent {
    /// Least coordinates of its points \[m\].
    pub low: [f64; 3],
    /// Greatest \[m\].
    pub high: [f64; 3],
    /// Speed of the fastest \[m/s\].
    pub speed: f64,
    /// Distance of its points \[m\].
    pub spacing: f64,
}

/// A surface whose points move: triangles between points, each with its place at rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MovingSurface {
    /// Corners, counter-clockwise seen from the outside, or from above in the reference plane.
    pub triangles: Vec<[u32; 3]>,
    /// Place of each point at rest, in its sheet's plane \[m\]; of a body that lies in no plane,
    /// what a texture is laid by.
    pub reference: Vec<[f32; 2]>,
    /// Thickness with which it is drawn \[m\]; 0 for a closed surface.
    pub thickness: f32,
}

/// Where the points of a surface are at one step.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceFrame {
    /// Steps of the rigid world before it.
    pub step: u64,
    /// Which of the window's surfaces.
    pub surface: u32,
    /// What places are counted from \[m\].
    pub origin: Vec3,
    /// Of each point \[m\].
    pub offsets: Vec<[f32; 3]>,
    /// The quantity that diffuses at each point; empty where none does.
    pub quantity: Vec<f32>,
}

/// A part that holds together by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct TornPiece {
    /// Its number, which it keeps while it does not come apart; 0 is the body at its start.
    pub number: u32,
    /// The piece that it came from.
    pub parent: u32,
    /// Steps of the rigid world before it came to be.
    pub born: u64,
    /// \[kg\].
    pub mass: f64,
    /// Area at rest \[m²\]: of a solid, of its outer surface.
    pub area: f64,
    /// Whether it is at rest and not simulated until something comes near.
    pub frozen: bool,
}

/// A piece that has come to rest, as a rigid body of its shape.
#[derive(Clone, Debug, PartialEq)]
pub struct SettledPiece {
    /// Its number.
    pub number: u32,
    /// What it fills, about its centre \[m\].
    pub solid: Arc<Solid>,
    /// Where its centre is \[m\].
    pub place: Vec3,
    /// \[kg\].
    pub mass: f64,
}

/// What came and went in a window. Energies \[J\] are counted with velocities at mid-step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct WindowLedger {
    /// Mass at its end \[kg\], with what it has taken up.
    pub mass: f64,
    /// Momentum at its end \[kg·m/s\].
    pub momentum: [f64; 3],
    /// Angular momentum about the world's origin at its end \[kg·m²/s\].
    pub angular_momentum: [f64; 3],
    /// Impulses of gravity, grips, air and bodies on it, less what its momentum grew by
    /// \[kg·m/s\].
    pub momentum_residual: [f64; 3],
    /// Kinetic energy at its end \[J\].
    pub kinetic: f64,
    /// Energy of stretched bonds at its end \[J\].
    pub stretching: f64,
    /// Energy of bending at its end \[J\].
    pub bending: f64,
    /// Work of separation in it \[J\].
    pub broken: f64,
    /// Plastic work in it \[J\].
    pub plastic: f64,
    /// What inner damping took in it \[J\].
    pub damped: f64,
    /// Work of the air on it \[J\].
    pub air: f64,
    /// Work of grips and pins on it \[J\].
    pub grips: f64,
    /// Work of gravity on it \[J\].
    pub gravity: f64,
    /// Work of rigid bodies on it \[J\].
    pub bodies: f64,
    /// Work of what it took up or lost, through stiffness that changed \[J\].
    pub quantity_work: f64,
    /// Energy that is there and should not be \[J\].
    pub residual: f64,
    /// Integral of the quantity that diffuses at its end.
    pub quantity: f64,
    /// What sources and sinks added to that integral in it.
    pub quantity_in: f64,
    /// Area of cracks at rest so far, length times thickness \[m²\].
    pub torn_area: f64,
}

impl WindowLedger {
    /// Its numbers by name, with their units.
    #[must_use]
    pub fn numbers(&self) -> [(&'static str, f64); 25] {
        let ([px, py, pz], [lx, ly, lz]) = (self.momentum, self.angular_momentum);
        let [rx, ry, rz] = self.momentum_residual;
        [
            ("mass [kg]", self.mass),
            ("momentum x [kg·m/s]", px),
            ("momentum y [kg·m/s]", py),
            ("momentum z [kg·m/s]", pz),
            ("angular momentum x [kg·m²/s]", lx),
            ("angular momentum y [kg·m²/s]", ly),
            ("angular momentum z [kg·m²/s]", lz),
            ("momentum residual x [kg·m/s]", rx),
            ("momentum residual y [kg·m/s]", ry),
            ("momentum residual z [kg·m/s]", rz),
            ("kinetic [J]", self.kinetic),
            ("stretching [J]", self.stretching),
            ("bending [J]", self.bending),
            ("broken [J]", self.broken),
            ("plastic [J]", self.plastic),
            ("damped [J]", self.damped),
            ("air [J]", self.air),
            ("grips [J]", self.grips),
            ("gravity [J]", self.gravity),
            ("bodies [J]", self.bodies),
            ("work by the quantity [J]", self.quantity_work),
            ("residual [J]", self.residual),
            ("quantity", self.quantity),
            ("quantity in", self.quantity_in),
            ("torn area [m²]", self.torn_area),
        ]
    }
}

/// What came of a window.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WindowOutcome {
    /// The body at its end, in the family's own canonical bytes.
    pub state: Vec<u8>,
    /// Where it is at its end.
    pub extent: SweptExtent,
    /// What bodies were given, one for each proxy, in their order.
    pub handed: Vec<Handed>,
    /// Surfaces that frames name.
    pub surfaces: Vec<MovingSurface>,
    /// What it looked like, by rising step.
    pub frames: Vec<SurfaceFrame>,
    /// The parts that it has come to, by number.
    pub pieces: Vec<TornPiece>,
    /// Those that have come to rest in it, where they shall become rigid bodies.
    pub settled: Vec<SettledPiece>,
    /// What came and went.
    pub ledger: WindowLedger,
    /// The family's own figures.
    pub figures: Vec<Figure>,
    /// What the reader should know.
    pub warnings: Vec<String>,
}

/// How far a window has come.
#[derive(Clone, Debug, PartialEq)]
pub enum WindowProgress {
    /// Share done \[0, 1\].
    Running(f64),
    /// Finished.
    Done(Box<WindowOutcome>),
    /// Numerics went wrong.
    Failed(Failure),
}

/// What a prepared body counts as where its family does not say \[bytes\].
pub const PREPARED_GUESS: u64 = 128 << 20;

/// A family of bodies that are simulated for as long as a scene lasts. It has a crate of its own
/// and one line in the worker's table.
pub trait Continuum: Sized + 'static {
    /// What is worked out once for a body: points, bonds, weights.
    type Prepared: Any + Send + Sync;
    /// Name on the wire and in recordings. Never reused for another method.
    const NAME: &'static str;
    /// Makes the body discrete.
    ///
    /// # Errors
    /// The bound that the body breaks.
    fn prepare(setup: &ContinuumSetup) -> Result<Self::Prepared, Refusal>;
    /// Begins a window at a state; without one, at the start of the body.
    ///
    /// # Errors
    /// A state that is not one of this body, or a bound that the window breaks.
    fn open(
        prepared: Arc<Self::Prepared>,
        state: Option<&[u8]>,
        window: Window,
    ) -> Result<Self, Refusal>;
    /// Advances by one bounded slice; the host looks for cancellation between slices.
    fn advance(&mut self) -> WindowProgress;
    /// Memory that a prepared body takes, about \[bytes\]: hosts keep some for the next windows.
    fn bytes(_prepared: &Self::Prepared) -> u64 {
        PREPARED_GUESS
    }
}

/// A window in progress, whatever its family.
pub trait WindowInProgress {
    /// See [`Continuum::advance`].
    fn advance(&mut self) -> WindowProgress;
}

impl<C: Continuum> WindowInProgress for C {
    fn advance(&mut self) -> WindowProgress {
        Continuum::advance(self)
    }
}

/// What a family worked out once for a body.
pub type PreparedBody = Arc<dyn Any + Send + Sync>;

/// Begins a window of a prepared body, as [`Continuum::open`].
pub type OpenWindow =
    fn(&PreparedBody, Option<&[u8]>, Window) -> Result<Box<dyn WindowInProgress>, Refusal>;

/// One line of the worker's table of families whose bodies move as they deform.
pub struct ContinuumEntry {
    /// [`Continuum::NAME`].
    pub name: &'static str,
    /// [`Continuum::prepare`].
    pub prepare: fn(&ContinuumSetup) -> Result<PreparedBody, Refusal>,
    /// [`Continuum::open`].
    pub open: OpenWindow,
    /// [`Continuum::bytes`].
    pub bytes: fn(&PreparedBody) -> u64,
}

/// The line of a family.
#[must_use]
pub const fn continuum_entry<C: Continuum>() -> ContinuumEntry {
    ContinuumEntry {
        name: C::NAME,
        prepare: |setup| Ok(Arc::new(C::prepare(setup)?)),
        open: |prepared, state, window| {
            let Ok(prepared) = Arc::clone(prepared).downcast::<C::Prepared>() else {
                let lack = "it was prepared by another family".to_owned();
                return Err(Refusal::Unfit { solver: C::NAME, lack });
            };
            Ok(Box::new(C::open(prepared, state, window)?))
        },
        bytes: |prepared| prepared.downcast_ref().map_or(PREPARED_GUESS, C::bytes),
    }
}
