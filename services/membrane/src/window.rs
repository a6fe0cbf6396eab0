//! A window of a sheet's time, as the worker solves it.

use crate::crossings::live_pairs;
use crate::detectors::{
    self, SheetCondition, WindowExtremes, drag_share, mass_ratio, pressed_through,
};
use crate::prepared::PreparedMembrane;
use crate::state::SheetState;
use crate::steps::{MOST_LENGTH, SheetRun};
use crate::surface::TornSurface;
use cullet_continuum::RigidProxy;
use cullet_continuum::crossings::crossings;
use cullet_continuum::pieces::torn_pieces;
use cullet_geometry::Vec3;
use cullet_model::outcome::STRENGTH_RATIO;
use cullet_model::sheet_check::{MOST_SWELLING, greater};
use cullet_model::{
    Continuum, ContinuumSetup, Failure, Figure, MembraneLaw, MembranePace, MovingSurface, Refusal,
    SurfaceFrame, SweptExtent, TornPiece, Window, WindowLedger, WindowOutcome, WindowProgress,
};
use std::sync::Arc;

/// Points times steps of one slice: about 5 ms.
const SLICE: usize = 60_000;
/// Momentum and the integral of what diffuses close to this share of what was exchanged.
const CLOSED: f64 = 1e-9;
/// Energy that is there and should not be, over what there is, above which a warning is given.
const ENERGY_SLACK: f64 = 0.02;
/// Of the integral of a quantity: θ times its capacity times volume.
const UNIT: &str = "capacity·θ·m³";
/// Kinetic over elastic energy of a heavier sheet above which a warning is given.
const MOST_KINETIC: f64 = 0.05;

/// A window of a thin sheet.
#[derive(Clone, Debug)]
pub struct MembraneWindow {
    run: SheetRun,
    window: Window,
    start: WindowStart,
    surfaces: Vec<MovingSurface>,
    frames: Vec<SurfaceFrame>,
    /// The surface of the last frame, and which pairs of points held then.
    torn: Option<(Vec<bool>, TornSurface)>,
    seen: WindowExtremes,
    done: u32,
}

/// What there was as a window began.
#[derive(Clone, Debug, Default)]
struct WindowStart {
    kinetic: f64,
    stored: f64,
    momentum: Vec3,
    quantities: Vec<f64>,
}

impl Continuum for MembraneWindow {
    type Prepared = PreparedMembrane;
    const NAME: &'static str = crate::family::NAME;

    fn prepare(setup: &ContinuumSetup) -> Result<Self::Prepared, Refusal> {
        PreparedMembrane::new(setup)
    }

    fn open(
        prepared: Arc<Self::Prepared>,
        state: Option<&[u8]>,
        window: Window,
    ) -> Result<Self, Refusal> {
        let mut state = match state {
            Some(bytes) => SheetState::decode(&prepared, bytes)?,
            None => SheetState::start(&prepared),
        };
        let unfit = |lack: String| Err(Refusal::Unfit { solver: crate::family::NAME, lack });
        if state.step != window.first_step {
            let (own, first) = (state.step, window.first_step);
            return unfit(format!("the state is that of step {own}, the window begins at {first}"));
        }
        if window.steps == 0 {
            return unfit("a window has at least one step".to_owned());
        }
        let proxies = window
            .proxies
            .iter()
            .map(|proxy| RigidProxy::new(proxy, window.steps, crate::family::NAME));
        let proxies = proxies.collect::<Result<Vec<_>, Refusal>>()?;
        let retired = window.retired.as_deref().unwrap_or_default();
        let (world_step, family) = (prepared.setup.world_step, crate::family::NAME);
        cullet_continuum::retire(&mut state.pieces, retired, world_step, family)?;
        let mut run = SheetRun::new(prepared, state, proxies);
        let start = WindowStart {
            kinetic: run.kinetic(),
            stored: run.energies().iter().sum(),
            momentum: momentum(&run),
            quantities: quantities(&run),
        };
        let mut window = Self {
            run,
            window,
            start,
            surfaces: vec![],
            frames: vec![],
            torn: None,
            seen: WindowExtremes::default(),
            done: 0,
        };
        window.seen.drag = drag_share(&window.run);
        if window.window.first_step == 0 && window.window.frame_every > 0 {
            window.show();
        }
        Ok(window)
    }

    fn advance(&mut self) -> WindowProgress {
        let slice = (SLICE / self.run.state.places.len()).max(1);
        for _ in 0..slice {
            if self.done == self.window.steps {
                return self.finish();
            }
            if !self.run.advance() {
                continue;
            }
            self.done += 1;
            self.seen.drag = self.seen.drag.max(drag_share(&self.run));
            if let Some(failure) = self.swollen().or_else(|| self.not_finite()) {
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

/// Momentum of a sheet \[kg·m/s\].
fn momentum(run: &SheetRun) -> Vec3 {
    run.masses.iter().zip(&run.state.velocities).map(|(m, v)| v * m[1]).sum()
}

/// ΣρChAθ of each quantity of a sheet.
fn quantities(run: &SheetRun) -> Vec<f64> {
    let all = run.prepared.diffusion.iter().enumerate();
    all.map(|(k, bonds)| bonds.total(run.state.theta_of(k))).collect()
}

impl MembraneWindow {
    /// The sheet's state now.
    #[must_use]
    pub fn state(&self) -> &SheetState {
        &self.run.state
    }

    fn not_finite(&self) -> Option<Failure> {
        let step = self.run.state.step;
        if let Some(what) = self.run.state.not_finite() {
            return Some(Failure::NotFinite { what, step });
        }
        if self.run.is_overstretched() {
            let what = format!("a bond is longer than {MOST_LENGTH} horizons");
            return Some(Failure::Beyond { what, step });
        }
        let moving = self.run.proxies.iter().all(RigidProxy::is_finite);
        (!moving).then_some(Failure::NotFinite { what: "the motion of a rigid body", step })
    }

    /// That what it has taken up stretches or shrinks it by more than a bond can follow.
    fn swollen(&self) -> Option<Failure> {
        let (state, quantities) = (&self.run.state, &self.run.prepared.sheet().diffusion);
        let strain = |i: usize| greater(quantities.strains(state.thetas_at(i)));
        let beyond = |i: &usize| strain(*i).abs() > MOST_SWELLING;
        let count = if quantities.is_empty() { 0 } else { state.places.len() };
        let point = (0..count).find(beyond)?;
        let all: Vec<String> = state.thetas_at(point).map(|theta| format!("{theta:.3e}")).collect();
        let (all, strain) = (all.join(" and "), strain(point));
        let what = format!(
            "what it takes up, {all}, strains it by {strain:.3}; {MOST_SWELLING} is the most"
        );
        Some(Failure::Beyond { what, step: self.run.state.step })
    }

    /// Takes a frame.
    fn show(&mut self) {
        let (run, prepared) = (&self.run, &self.run.prepared);
        let state = &run.state;
        let slopes = run.slopes();
        let alive = live_pairs(prepared, &state.damage);
        let crossed = crossings(&run.whole_triangles(&alive), &state.places).len();
        self.seen.crossed = self.seen.crossed.max(crossed);
        let torn = match self.torn.take() {
            Some((before, torn)) if before == alive => torn,
            _ => {
                let torn = run.torn_surface(&alive);
                self.surfaces.push(torn.surface.clone());
                torn
            }
        };
        let places = torn.places(&state.places, &slopes);
        let quantities = &prepared.sheet().diffusion;
        let quantity = match quantities.is_empty() {
            true => Vec::new(),
            false => torn.quantities(state.theta_of(quantities.shown as usize)),
        };
        let origin = places.iter().sum::<Vec3>() / places.len().max(1) as f64;
        self.frames.push(SurfaceFrame {
            step: state.step,
            surface: self.surfaces.len() as u32 - 1,
            origin,
            offsets: places
                .iter()
                .map(|x| <[f64; 3]>::from(x - origin).map(|c| c as f32))
                .collect(),
            quantity,
        });
        self.torn = Some((alive, torn));
    }

    fn pieces(&self) -> Vec<TornPiece> {
        let (state, prepared) = (&self.run.state, &self.run.prepared);
        let of = |i: usize| (self.run.masses[i][0], prepared.points.areas[i]);
        torn_pieces(&state.labels, &state.pieces, prepared.setup.world_step, of)
    }

    /// Length of cracks at rest times the thickness \[m²\]: what their bonds would have cost where
    /// nothing weakens them, over G.
    fn torn_area(&self) -> f64 {
        let prepared = &self.run.prepared;
        let bonds = &prepared.bonds;
        let broken = |b: &usize| self.run.state.damage[*b] >= 1.0 && !bonds.cut[*b];
        let cost: f64 = (0..bonds.ends.len()).filter(broken).map(|b| bonds.stiffness[b]).sum();
        let toughness = prepared.sheet().material.fracture_energy;
        0.25 * cost * prepared.critical * prepared.critical / toughness
    }

    fn ledger(&mut self) -> WindowLedger {
        let [stretching, bending] = self.run.energies();
        let run = &self.run;
        let (books, sums) = (&run.books, &run.books.sums);
        let kinetic = run.kinetic();
        let own = momentum(run);
        let angular: Vec3 = (run.masses.iter().zip(&run.state.places))
            .zip(&run.state.velocities)
            .map(|((m, x), v)| x.cross(v) * m[1])
            .sum();
        let shown = run.prepared.sheet().diffusion.shown as usize;
        let of_shown = |all: &[f64]| all.get(shown).copied().unwrap_or(0.0);
        let grew = kinetic + stretching + bending - self.start.kinetic - self.start.stored;
        let spent = sums.broken + sums.plastic + sums.damped;
        let given = sums.air + sums.grips + sums.gravity + sums.bodies + books.quantity_work;
        WindowLedger {
            mass: run.masses.iter().map(|m| m[0]).sum(),
            momentum: own.into(),
            angular_momentum: angular.into(),
            momentum_residual: (sums.impulse - (own - self.start.momentum)).into(),
            kinetic,
            stretching,
            bending,
            broken: sums.broken,
            plastic: sums.plastic,
            damped: sums.damped,
            air: sums.air,
            grips: sums.grips,
            gravity: sums.gravity,
            bodies: sums.bodies,
            quantity_work: books.quantity_work,
            residual: grew + spent - given,
            quantity: of_shown(&quantities(run)),
            quantity_in: of_shown(&books.quantities_in),
            torn_area: self.torn_area(),
        }
    }

    /// That momentum and what diffuses are all accounted for.
    fn unbalanced(&self, ledger: &WindowLedger) -> Option<Failure> {
        let step = self.run.state.step;
        let momenta = self.run.masses.iter().zip(&self.run.state.velocities);
        let moving: f64 = momenta.map(|(m, v)| m[1] * v.norm()).sum();
        let scale = self.run.books.sums.exchanged + moving;
        let lost = Vec3::from(ledger.momentum_residual).norm();
        if lost > CLOSED * scale {
            let what = format!("momentum is off by {lost:.3e} of {scale:.3e} kg·m/s exchanged");
            return Some(Failure::Beyond { what, step });
        }
        for (k, end) in quantities(&self.run).into_iter().enumerate() {
            let (start, came) = (self.start.quantities[k], self.run.books.quantities_in[k]);
            let lost = end - start - came;
            let scale = end.abs() + start.abs() + came.abs();
            if lost.abs() > CLOSED * scale {
                let name = self.run.prepared.sheet().diffusion.name(k);
                let what = format!("the {name} that diffuses is off by {lost:.3e} of {scale:.3e}");
                return Some(Failure::Beyond { what, step });
            }
        }
        None
    }

    /// What there is of each quantity at the end and what came of it, where there are several: the
    /// ledger has the one that is shown.
    fn of_quantities(&self) -> Vec<(String, &'static str, f64)> {
        let names = &self.run.prepared.sheet().diffusion;
        let totals = quantities(&self.run);
        let both = totals.iter().zip(&self.run.books.quantities_in).enumerate();
        let rows = both.flat_map(|(k, (total, came))| {
            let name = names.name(k);
            [(format!("{name}_total"), UNIT, *total), (format!("{name}_in"), UNIT, *came)]
        });
        if totals.len() > 1 { rows.collect() } else { Vec::new() }
    }

    fn figures(&self, condition: &SheetCondition) -> Vec<Figure> {
        let prepared = &self.run.prepared;
        let limits = prepared.limits();
        let length = f64::from(self.done) * prepared.setup.world_step;
        let mass: f64 = self.run.masses.iter().map(|m| m[0]).sum();
        let mut figures = vec![
            ("working_wave_speed", "m/s", prepared.pace.speed),
            ("working_inertia", "1", prepared.pace.inertia),
            ("working_young", "Pa", prepared.pace.young),
            ("critical_stretch", "1", limits.critical),
            ("first_stretch", "1", limits.first),
            (STRENGTH_RATIO, "1", limits.first / prepared.strength),
            ("bending_ratio", "1", prepared.bending_ratio),
            ("points", "1", prepared.points.places.len() as f64),
            ("bonds", "1", 0.5 * prepared.bonds.ends.len() as f64),
            ("steps", "1", self.run.books.steps as f64),
            ("step", "s", prepared.step()),
        ]
        .into_iter()
        .chain(detectors::figures(&self.run, condition, self.seen))
        .map(|(name, unit, value)| (name.to_owned(), unit, value))
        .collect::<Vec<_>>();
        figures.extend(self.of_quantities());
        for (k, impulse) in self.run.books.grips.iter().enumerate() {
            for (axis, part) in ["x", "y", "z"].iter().zip(impulse.iter()) {
                figures.push((format!("grip_{}_force_{axis}", k + 1), "N", part / length));
            }
        }
        for (proxy, handed) in self.run.proxies.iter().zip(&self.window.proxies) {
            figures.push((format!("body_{}_depth", handed.body), "m", proxy.deepest));
            if let Some(ratio) = mass_ratio(handed, mass) {
                figures.push((format!("body_{}_mass_ratio", handed.body), "1", ratio));
            }
        }
        let figure = |(name, unit, value): (String, &str, f64)| Figure {
            name,
            unit: unit.to_owned(),
            value,
        };
        figures.into_iter().map(figure).collect()
    }

    fn warnings(&self, ledger: &WindowLedger, condition: &SheetCondition) -> Vec<String> {
        let mut warnings = detectors::warnings(&self.run, condition, self.seen);
        let prepared = &self.run.prepared;
        let elastic = ledger.stretching + ledger.bending;
        let works = [ledger.air, ledger.grips, ledger.gravity, ledger.bodies];
        let moved: f64 = works.iter().map(|work| work.abs()).sum();
        let scale = moved + ledger.kinetic + elastic + self.start.kinetic + self.start.stored;
        if ledger.residual.abs() > ENERGY_SLACK * scale {
            warnings.push(format!(
                "energy is off by {:.3e} J of {scale:.3e} J in this window",
                ledger.residual
            ));
        }
        let heavier = matches!(prepared.sheet().pace, MembranePace::Heavier(_));
        if heavier && ledger.kinetic > MOST_KINETIC * elastic {
            warnings.push(format!(
                "the heavier sheet moves with {:.3e} J beside {elastic:.3e} J of strain: more than \
                 a twentieth; take a faster pace or load it more slowly",
                ledger.kinetic
            ));
        }
        let limits = prepared.limits();
        if limits.first < prepared.strength * (1.0 - 1e-9) {
            let law = prepared.sheet().material.law;
            let what = if law == MembraneLaw::Foil { "yields" } else { "softens" };
            warnings.push(format!(
                "a bond {what} at {:.2} of the strength: at this spacing cracks are controlled by \
                 toughness alone",
                limits.first / prepared.strength
            ));
        }
        for (number, notch) in prepared.sheet().notches.iter().enumerate() {
            let (places, spacing) = (&prepared.points.places, prepared.sheet().spacing);
            let caught = |end: &&[f64; 2]| {
                prepared.grips.iter().any(|grip| grip.guards(**end, places, spacing))
            };
            if notch.last().iter().any(caught) {
                warnings.push(format!(
                    "notch {} ends within two horizons of a grip, where nothing breaks: make it \
                     longer, or take a finer spacing",
                    number + 1
                ));
            }
        }
        for (proxy, handed) in self.run.proxies.iter().zip(&self.window.proxies) {
            let contact = prepared.contact();
            warnings.extend(pressed_through(handed, proxy.deepest, contact, ledger.mass));
        }
        warnings
    }

    fn extent(&self) -> SweptExtent {
        let (state, gone) = (&self.run.state, &self.run.gone);
        // Where nothing is left, it is where it was.
        let none = gone.iter().all(|gone| *gone);
        let here = |(x, gone): (&'_ Vec3, &bool)| (!gone || none).then_some(*x);
        let places: Vec<Vec3> = state.places.iter().zip(gone).filter_map(here).collect();
        let bound = |pick: fn(f64, f64) -> f64, from: f64| -> [f64; 3] {
            std::array::from_fn(|k| places.iter().map(|x| x[k]).fold(from, pick))
        };
        SweptExtent {
            low: bound(f64::min, f64::MAX),
            high: bound(f64::max, f64::MIN),
            speed: state.velocities.iter().map(Vec3::norm).fold(0.0, f64::max),
            spacing: self.run.prepared.sheet().spacing,
        }
    }

    fn finish(&mut self) -> WindowProgress {
        let ledger = self.ledger();
        if let Some(failure) = self.unbalanced(&ledger) {
            return WindowProgress::Failed(failure);
        }
        let condition = SheetCondition::of(&self.run);
        let offer = self.settled();
        let mut figures = self.figures(&condition);
        let mut warnings = self.warnings(&ledger, &condition);
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
#[cfg(test)]
mod tests;
