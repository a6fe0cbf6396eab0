//! A window of a soft shell's time, as the worker solves it.

use super::NAME;
use super::draw::PartedSurface;
use super::prepared::{PreparedFunctions, PreparedSoftShell, PreparedWall};
use super::run::SoftShellRun;
use super::state::{RetiredShare, SoftShellState};
use cullet_continuum::RigidProxy;
use cullet_geometry::Vec3;
use cullet_model::{
    Continuum, ContinuumSetup, Failure, MovingSurface, Refusal, SurfaceFrame, Window,
    WindowOutcome, WindowProgress,
};
use std::sync::Arc;

/// Control points times steps of one slice: some tens of milliseconds.
const SLICE: usize = 30_000;

/// A window of a soft shell.
#[derive(Debug)]
pub struct SoftShellWindow(Box<dyn WallSlices>);

/// A window that goes on slice by slice, whatever its functions.
trait WallSlices: std::fmt::Debug + Send {
    fn advance(&mut self) -> WindowProgress;
}

impl Continuum for SoftShellWindow {
    type Prepared = PreparedSoftShell;
    const NAME: &'static str = NAME;

    fn prepare(setup: &ContinuumSetup) -> Result<Self::Prepared, Refusal> {
        PreparedSoftShell::new(setup)
    }

    fn open(
        prepared: Arc<Self::Prepared>,
        state: Option<&[u8]>,
        window: Window,
    ) -> Result<Self, Refusal> {
        Ok(Self(match &prepared.0 {
            PreparedFunctions::Nine(wall) => Box::new(WallWindow::new(wall, state, window)?),
            PreparedFunctions::Sixteen(wall) => Box::new(WallWindow::new(wall, state, window)?),
        }))
    }

    fn advance(&mut self) -> WindowProgress {
        self.0.advance()
    }

    fn bytes(prepared: &Self::Prepared) -> u64 {
        prepared.bytes()
    }
}

/// A window of a soft shell whose cells have `N` functions.
#[derive(Debug)]
pub(super) struct WallWindow<const N: usize> {
    pub(super) run: SoftShellRun<N>,
    pub(super) window: Window,
    pub(super) start: ShellStart,
    /// What left it as it began.
    pub(super) retired: RetiredShare,
    pub(super) surfaces: Vec<MovingSurface>,
    pub(super) frames: Vec<SurfaceFrame>,
    /// The surface of the last frame.
    drawn: Option<PartedSurface>,
    pub(super) done: u32,
}

/// What there was as a window began.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ShellStart {
    pub(super) kinetic: f64,
    pub(super) stored: f64,
    pub(super) momentum: Vec3,
}

impl<const N: usize> WallSlices for WallWindow<N> {
    fn advance(&mut self) -> WindowProgress {
        self.slice()
    }
}

impl<const N: usize> WallWindow<N> {
    pub(super) fn new(
        prepared: &Arc<PreparedWall<N>>,
        state: Option<&[u8]>,
        window: Window,
    ) -> Result<Self, Refusal> {
        let mut state = match state {
            Some(bytes) => SoftShellState::decode(prepared, bytes)?,
            None => SoftShellState::start(prepared),
        };
        let unfit = |lack: String| Err(Refusal::Unfit { solver: NAME, lack });
        if state.step != window.first_step {
            let (own, first) = (state.step, window.first_step);
            return unfit(format!("the state is that of step {own}, the window begins at {first}"));
        }
        if window.steps == 0 {
            return unfit("a window has at least one step".to_owned());
        }
        let proxies = window.proxies.iter();
        let proxies = proxies.map(|proxy| RigidProxy::new(proxy, window.steps, NAME));
        let proxies = proxies.collect::<Result<Vec<_>, Refusal>>()?;
        let numbers = window.retired.as_deref().unwrap_or_default();
        let retired = state.retire(numbers, prepared.setup.world_step)?;
        let mut run = SoftShellRun::new(Arc::clone(prepared), state, proxies);
        let start = ShellStart {
            kinetic: run.kinetic(),
            stored: run.energies().iter().sum(),
            momentum: run.momentum(),
        };
        let (surfaces, frames) = (Vec::new(), Vec::new());
        let (drawn, done) = (None, 0);
        let mut window = Self { run, window, start, retired, surfaces, frames, drawn, done };
        if window.window.first_step == 0 && window.window.frame_every > 0 {
            window.show();
        }
        Ok(window)
    }

    /// Advances by one slice.
    pub(super) fn slice(&mut self) -> WindowProgress {
        let slice = (SLICE / self.run.state.domain.mass.len()).max(1);
        for _ in 0..slice {
            if self.done == self.window.steps {
                return self.finish();
            }
            if !self.run.advance() {
                continue;
            }
            self.done += 1;
            if let Some(failure) = self.not_finite() {
                return WindowProgress::Failed(failure);
            }
            let every = u64::from(self.window.frame_every);
            if every > 0 && self.run.state.step.is_multiple_of(every) {
                self.show();
            }
        }
        match self.done == self.window.steps {
            true => self.finish(),
            false => WindowProgress::Running(self.run.come() / f64::from(self.window.steps)),
        }
    }

    fn not_finite(&self) -> Option<Failure> {
        let step = self.run.state.step;
        if let Some(what) = self.run.state.not_finite() {
            return Some(Failure::NotFinite { what, step });
        }
        let moving = self.run.proxies.iter().all(RigidProxy::is_finite);
        (!moving).then_some(Failure::NotFinite { what: "the motion of a rigid body", step })
    }

    /// Takes a frame.
    fn show(&mut self) {
        let (state, prepared) = (&self.run.state, &self.run.prepared);
        let drawn = match self.drawn.take() {
            Some(drawn) if drawn.holds(&state.domain) => drawn,
            _ => {
                let drawn =
                    PartedSurface::new(&prepared.lattice, &state.domain, prepared.thickness);
                self.surfaces.push(drawn.surface.clone());
                drawn
            }
        };
        let places = drawn.places(&state.domain);
        let origin = places.iter().sum::<Vec3>() / places.len().max(1) as f64;
        let offset = |x: &Vec3| <[f64; 3]>::from(x - origin).map(|c| c as f32);
        self.frames.push(SurfaceFrame {
            step: state.step,
            surface: self.surfaces.len() as u32 - 1,
            origin,
            offsets: places.iter().map(offset).collect(),
            quantity: Vec::new(),
        });
        self.drawn = Some(drawn);
    }

    fn finish(&mut self) -> WindowProgress {
        let ledger = self.ledger();
        if let Some(failure) = self.unbalanced(&ledger) {
            return WindowProgress::Failed(failure);
        }
        let offer = self.settled();
        let (mut figures, mut warnings) = (self.figures(), self.warnings(&ledger));
        offer.tell(&mut figures, &mut warnings);
        WindowProgress::Done(Box::new(WindowOutcome {
            state: self.run.state.encode(&self.run.prepared),
            extent: self.extent(),
            handed: self.run.proxies.iter().map(RigidProxy::handed).collect(),
            surfaces: std::mem::take(&mut self.surfaces),
            frames: std::mem::take(&mut self.frames),
            pieces: self.pieces(),
            settled: offer.settled,
            figures,
            warnings,
            ledger,
        }))
    }
}
