//! A window of a soft solid's time, as the worker solves it.

use super::prepared::PreparedSoftSolid;
use super::state::SoftSolidState;
use super::steps::SolidRun;
use super::surface::{CarriedSurface, HeldBonds, TornSolid};
use crate::domain::limits::MOST_DRIFT;
use cullet_continuum::RigidProxy;
use cullet_continuum::pieces::torn_pieces;
use cullet_geometry::Vec3;
use cullet_model::{
    Continuum, ContinuumSetup, Failure, Figure, MembranePace, MovingSurface, Refusal, SurfaceFrame,
    SweptExtent, TornPiece, Window, WindowLedger, WindowOutcome, WindowProgress,
};
use std::sync::Arc;

/// Points times steps of one slice: about 20 ms.
const SLICE: usize = 40_000;
/// Momentum closes to this share of what was exchanged.
const CLOSED: f64 = 1e-9;
/// Energy that is there and should not be, over what there is, above which a warning is given.
const ENERGY_SLACK: f64 = 0.02;
/// Steps of the world between looks at the volume of all points.
const CHECK: u64 = 4;
/// Greatest share of a body that may be crushed \[1\]: a corner, not a side.
const MOST_CRUSHED: f64 = 0.02;
/// Kinetic over elastic energy of a heavier body above which a warning is given.
const MOST_KINETIC: f64 = 0.05;

/// A window of a soft solid.
pub struct SoftSolidWindow {
    run: SolidRun,
    window: Window,
    start: SolidStart,
    surfaces: Vec<MovingSurface>,
    frames: Vec<SurfaceFrame>,
    /// The surface of the last frame, and which bonds held then.
    drawn: Option<(HeldBonds, CarriedSurface)>,
    done: u32,
    strained: SolidStrained,
}

/// How far the body was strained at most.
#[derive(Clone, Copy, Debug, Default)]
struct SolidStrained {
    /// Change of volume that no pressure explains \[1\].
    drift: f64,
    /// Share of the body that had less than a fifth of its volume \[1\].
    crushed: f64,
}

/// What there was as a window began.
#[derive(Clone, Copy, Debug, Default)]
struct SolidStart {
    kinetic: f64,
    stored: f64,
    momentum: Vec3,
}

impl Continuum for SoftSolidWindow {
    type Prepared = PreparedSoftSolid;
    const NAME: &'static str = super::NAME;

    fn prepare(setup: &ContinuumSetup) -> Result<Self::Prepared, Refusal> {
        PreparedSoftSolid::new(setup)
    }

    fn open(
        prepared: Arc<Self::Prepared>,
        state: Option<&[u8]>,
        window: Window,
    ) -> Result<Self, Refusal> {
        let mut state = match state {
            Some(bytes) => SoftSolidState::decode(&prepared, bytes)?,
            None => SoftSolidState::start(&prepared),
        };
        let unfit = |lack: String| Err(Refusal::Unfit { solver: super::NAME, lack });
        if state.step != window.first_step {
            let (own, first) = (state.step, window.first_step);
            return unfit(format!("the state is that of step {own}, the window begins at {first}"));
        }
        if window.steps == 0 {
            return unfit("a window has at least one step".to_owned());
        }
        let proxies =
            window.proxies.iter().map(|proxy| RigidProxy::new(proxy, window.steps, super::NAME));
        let proxies = proxies.collect::<Result<Vec<_>, Refusal>>()?;
        let retired = window.retired.as_deref().unwrap_or_default();
        cullet_continuum::retire(
            &mut state.pieces,
            retired,
            prepared.setup.world_step,
            super::NAME,
        )?;
        let run = SolidRun::new(prepared, state, proxies);
        let start = SolidStart {
            kinetic: run.kinetic(),
            // Ties that were dropped at once are booked as broken.
            stored: run.stored() + run.books.sums.broken,
            momentum: run.momentum(),
        };
        let (surfaces, frames) = (Vec::new(), Vec::new());
        let mut window = Self {
            run,
            window,
            start,
            surfaces,
            frames,
            drawn: None,
            done: 0,
            strained: SolidStrained::default(),
        };
        if window.window.first_step == 0 && window.window.frame_every > 0 {
            window.show();
        }
        Ok(window)
    }

    fn advance(&mut self) -> WindowProgress {
        let slice = (SLICE / self.run.masses.len()).max(1);
        for _ in 0..slice {
            if self.done == self.window.steps {
                return self.finish();
            }
            if !self.run.advance() {
                continue;
            }
            self.done += 1;
            if let Some(failure) = self.failed() {
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

    fn bytes(prepared: &Self::Prepared) -> u64 {
        prepared.bytes()
    }
}

impl SoftSolidWindow {
    /// The body's state now.
    #[must_use]
    pub fn state(&self) -> &SoftSolidState {
        &self.run.state
    }

    /// Why the body is none any more that bonds hold for.
    fn failed(&mut self) -> Option<Failure> {
        let step = self.run.state.step;
        if let Some(what) = self.run.state.not_finite() {
            return Some(Failure::NotFinite { what, step });
        }
        if !self.run.proxies.iter().all(RigidProxy::is_finite) {
            return Some(Failure::NotFinite { what: "the motion of a rigid body", step });
        }
        if let Err(limit) = self.run.state.domain.check_flow() {
            return Some(Failure::Beyond { what: limit.to_string(), step });
        }
        if !step.is_multiple_of(CHECK) {
            return None;
        }
        let found = self.run.state.domain.volume_change();
        // Large elastic strains that differ by direction count as a change of volume too.
        self.strained.drift = match found.drift.abs() > self.strained.drift.abs() {
            true => found.drift,
            false => self.strained.drift,
        };
        self.strained.crushed = self.strained.crushed.max(found.crushed);
        (found.crushed > MOST_CRUSHED).then(|| Failure::Beyond {
            what: format!(
                "{:.3} of a soft solid has less than a fifth of its volume, at most \
                 {MOST_CRUSHED} may: take a stiffer body, or a softer hit",
                found.crushed
            ),
            step,
        })
    }

    /// Takes a frame.
    fn show(&mut self) {
        let (prepared, state) = (&self.run.prepared, &self.run.state);
        let held = HeldBonds::of(&state.domain, prepared.body().spacing);
        let drawn = match self.drawn.take() {
            Some((before, drawn)) if before == held => drawn,
            _ => {
                let drawn = TornSolid::surface(&prepared.surface, &held).without(&self.run.gone);
                self.surfaces.push(drawn.surface.clone());
                drawn
            }
        };
        let places = drawn.places(&state.domain, &prepared.rest);
        let origin = places.iter().sum::<Vec3>() / places.len().max(1) as f64;
        let offset = |x: &Vec3| <[f64; 3]>::from(x - origin).map(|c| c as f32);
        self.frames.push(SurfaceFrame {
            step: state.step,
            surface: self.surfaces.len() as u32 - 1,
            origin,
            offsets: places.iter().map(offset).collect(),
            quantity: Vec::new(),
        });
        self.drawn = Some((held, drawn));
    }

    fn pieces(&self) -> Vec<TornPiece> {
        let (state, prepared) = (&self.run.state, &self.run.prepared);
        let of = |p: usize| (self.run.masses[p][0], prepared.areas[p].norm());
        torn_pieces(&state.labels, &state.pieces, prepared.setup.world_step, of)
    }

    /// Area of cracks at rest \[m²\]: a plane cuts ½Σwl₀ of bonds over its area, counted at both
    /// ends.
    fn torn_area(&self) -> f64 {
        let (prepared, domain) = (&self.run.prepared, &self.run.state.domain);
        let mut sum = 0.0;
        for p in 0..domain.places.len() {
            let broken = domain.bonds.of(p).filter(|&b| domain.left(b) == 0.0);
            let own = broken.filter(|&b| prepared.domain.left(b) > 0.0);
            sum += domain.volumes[p] * own.map(|b| domain.weight(p, b)).sum::<f64>();
        }
        2.0 * sum / prepared.reach
    }

    fn ledger(&self) -> WindowLedger {
        let (run, sums) = (&self.run, &self.run.books.sums);
        let (kinetic, stored, own) = (run.kinetic(), run.stored(), run.momentum());
        let domain = &run.state.domain;
        let angular: Vec3 = (run.masses.iter().zip(&domain.places))
            .zip(&domain.velocities)
            .map(|((m, x), v)| x.cross(v) * m[1])
            .sum();
        let grew = kinetic + stored - self.start.kinetic - self.start.stored;
        let spent = sums.broken + sums.plastic + sums.damped;
        let given = sums.air + sums.grips + sums.gravity + sums.bodies;
        WindowLedger {
            mass: run.masses.iter().map(|m| m[0]).sum(),
            momentum: own.into(),
            angular_momentum: angular.into(),
            momentum_residual: (sums.impulse - (own - self.start.momentum)).into(),
            kinetic,
            stretching: stored,
            broken: sums.broken,
            plastic: sums.plastic,
            damped: sums.damped,
            air: sums.air,
            grips: sums.grips,
            gravity: sums.gravity,
            bodies: sums.bodies,
            residual: grew + spent - given,
            torn_area: self.torn_area(),
            ..WindowLedger::default()
        }
    }

    /// That momentum is all accounted for.
    fn unbalanced(&self, ledger: &WindowLedger) -> Option<Failure> {
        let step = self.run.state.step;
        let moving = self.run.masses.iter().zip(&self.run.state.domain.velocities);
        let moving: f64 = moving.map(|(m, v)| m[1] * v.norm()).sum();
        let scale = self.run.books.sums.exchanged + moving;
        let lost = Vec3::from(ledger.momentum_residual).norm();
        (lost > CLOSED * scale).then(|| Failure::Beyond {
            what: format!("momentum is off by {lost:.3e} of {scale:.3e} kg·m/s exchanged"),
            step,
        })
    }

    fn figures(&self) -> Vec<Figure> {
        let (prepared, run) = (&self.run.prepared, &self.run);
        let domain = &run.state.domain;
        let length = f64::from(self.done) * prepared.setup.world_step;
        let plastic = domain.states.iter().map(|state| state.plastic).fold(0.0, f64::max);
        let young = prepared.pace.material.young;
        let mut figures: Vec<(String, &str, f64)> = [
            ("working_wave_speed", "m/s", prepared.pace.speed),
            ("working_inertia", "1", prepared.pace.inertia),
            ("working_young", "Pa", young),
            ("points", "1", run.masses.len() as f64),
            ("bonds", "1", 0.5 * domain.bonds.count() as f64),
            ("loose_points", "1", domain.bonds.loose as f64),
            ("steps", "1", run.books.steps as f64),
            ("step", "s", prepared.step()),
            ("plastic_strain", "1", plastic),
        ]
        .map(|(name, unit, value)| (name.to_owned(), unit, value))
        .into();
        if domain.critical.is_finite() {
            figures.push(("critical_stretch".to_owned(), "1", domain.critical));
            figures.push(("first_stretch".to_owned(), "1", 0.5 * domain.critical));
        }
        let books = run.books.grips.iter().zip(&run.books.moments);
        for (k, (impulse, moment)) in books.enumerate() {
            for (axis, part) in ["x", "y", "z"].iter().zip(impulse.iter()) {
                figures.push((format!("grip_{}_force_{axis}", k + 1), "N", part / length));
            }
            for (axis, part) in ["x", "y", "z"].iter().zip(moment.iter()) {
                figures.push((format!("grip_{}_moment_{axis}", k + 1), "N·m", part / length));
            }
        }
        for (proxy, handed) in run.proxies.iter().zip(&self.window.proxies) {
            figures.push((format!("body_{}_depth", handed.body), "m", proxy.deepest));
        }
        let figure = |(name, unit, value): (String, &str, f64)| Figure {
            name,
            unit: unit.to_owned(),
            value,
        };
        figures.into_iter().map(figure).collect()
    }

    fn warnings(&self, ledger: &WindowLedger) -> Vec<String> {
        let mut warnings = Vec::new();
        let prepared = &self.run.prepared;
        let works = [ledger.air, ledger.grips, ledger.gravity, ledger.bodies];
        let moved: f64 = works.iter().map(|work| work.abs()).sum();
        let begun = self.start.kinetic + self.start.stored;
        let scale = moved + ledger.kinetic + ledger.stretching + begun;
        if ledger.residual.abs() > ENERGY_SLACK * scale {
            warnings.push(format!(
                "energy is off by {:.3e} J of {scale:.3e} J in this window",
                ledger.residual
            ));
        }
        let heavier = matches!(prepared.body().pace, MembranePace::Heavier(_));
        if heavier && ledger.kinetic > MOST_KINETIC * ledger.stretching {
            warnings.push(format!(
                "the heavier body moves with {:.3e} J beside {:.3e} J of strain: more than a \
                 twentieth; take a faster pace or load it more slowly",
                ledger.kinetic, ledger.stretching
            ));
        }
        let SolidStrained { drift, crushed } = self.strained;
        if drift.abs() > MOST_DRIFT {
            warnings.push(format!(
                "strains are large: the volume is off by {drift:+.3} from what pressures explain"
            ));
        }
        if crushed > 0.0 {
            warnings.push(format!(
                "{crushed:.4} of the body had less than a fifth of its volume: it is held apart \
                 there, and bears more than its law says"
            ));
        }
        let (jumped, unbooked) = self.run.books.jumped;
        if unbooked.abs() > ENERGY_SLACK * scale {
            warnings.push(format!(
                "{jumped} bonds were drawn from pressed to broken in one step: their work is too \
                 low by {unbooked:.3e} J"
            ));
        }
        for (proxy, handed) in self.run.proxies.iter().zip(&self.window.proxies) {
            if proxy.deepest > 2.0 * prepared.contact_distance() {
                let (depth, body) = (proxy.deepest, handed.body);
                warnings.push(format!("points were {depth:.3e} m inside of body {body}"));
            }
        }
        warnings
    }

    fn extent(&self) -> SweptExtent {
        let (domain, gone) = (&self.run.state.domain, &self.run.gone);
        // Where nothing is left, it is where it was.
        let none = gone.iter().all(|gone| *gone);
        let here = |(x, gone): (&Vec3, &bool)| (!gone || none).then_some(*x);
        let places: Vec<Vec3> = domain.places.iter().zip(gone).filter_map(here).collect();
        let bound = |pick: fn(f64, f64) -> f64, from: f64| -> [f64; 3] {
            std::array::from_fn(|k| places.iter().map(|x| x[k]).fold(from, pick))
        };
        SweptExtent {
            low: bound(f64::min, f64::MAX),
            high: bound(f64::max, f64::MIN),
            speed: domain.velocities.iter().map(Vec3::norm).fold(0.0, f64::max),
            spacing: self.run.prepared.body().spacing,
        }
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

mod settled;
