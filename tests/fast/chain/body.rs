//! The chain: point masses along the longest side of a box, axial springs between neighbours, a
//! turning spring at each mass. Bernoulli's beam: no shear, no lateral inertia of sections.

use cullet_geometry::Vec3;
use cullet_model::Refusal;
use cullet_specimen::{
    BodySums, Discretisation, Drive, FieldValues, Hold, LoadKind, LocalVector, PointField,
    PointFields, SpecimenProblem, StepTally, within,
};

/// Point masses on a line.
#[derive(Debug)]
pub(super) struct Chain {
    /// The axis that it lies along.
    along: usize,
    /// Distance between masses \[m\].
    pitch: f64,
    section: Section,
    places: Vec<Vec3>,
    masses: Vec<f64>,
    displacement: Vec<Vec3>,
    velocity: Vec<Vec3>,
    holds: Vec<Hold>,
    /// By support: its masses.
    held: Vec<Vec<usize>>,
    /// By load: the force on each mass \[N\].
    pushed: Vec<Vec<Vec3>>,
}

/// The section of the bar.
#[derive(Clone, Copy, Debug)]
struct Section {
    /// Young's modulus \[Pa\], density \[kg/m³\] and area \[m²\].
    young: f64,
    density: f64,
    area: f64,
    /// Second moment of area against bending along each axis \[m⁴\].
    second: Vec3,
}

impl Chain {
    /// # Errors
    /// The body is no box, or a support takes none of it or lets go.
    pub(super) fn new(problem: &SpecimenProblem, stiffness: f64) -> Result<Self, Refusal> {
        let (low, high) = problem.body.mesh.bounds().unwrap_or_default();
        let size = high - low;
        let along = size.imax();
        let filled = problem.body.mesh.signed_volume() / size.product();
        if (filled - 1.0).abs() > 1e-9 {
            let what = "the share of its box that the body fills";
            return Err(Refusal::OutOfRange { what, value: filled, low: 1.0, high: 1.0 });
        }
        let count = (size[along] / problem.settings.spacing).round().max(2.0);
        let pitch = size[along] / count;
        let area = size.product() / size[along];
        let material = &problem.matter.material;
        let section = Section {
            young: stiffness * material.young,
            density: material.density,
            area,
            second: size.map(|side| area * side * side / 12.0),
        };
        let last = count as usize;
        let place = |k: usize| {
            let mut x = (low + high) / 2.0;
            x[along] = low[along] + pitch * k as f64;
            x
        };
        let places: Vec<Vec3> = (0..=last).map(place).collect();
        let mass = material.density * area * pitch;
        let masses: Vec<f64> =
            (0..=last).map(|k| if k == 0 || k == last { mass / 2.0 } else { mass }).collect();
        let slack = 1e-6 * problem.settings.spacing;
        let taken =
            |hold: &Hold| (0..=last).filter(|&k| within(&hold.part, &places[k], slack)).collect();
        let held: Vec<Vec<usize>> = problem.holds.iter().map(taken).collect();
        let pushed = problem.loads.iter().map(|load| {
            let LoadKind::Acceleration(rate) = load.push else {
                return vec![Vec3::zeros(); last + 1];
            };
            let inside = |x: &Vec3| f64::from(u8::from(within(&load.part, x, 0.0)));
            places.iter().zip(&masses).map(|(x, mass)| rate * (mass * inside(x))).collect()
        });
        let pushed = pushed.collect();
        // A clamp that lets go would change which springs there are.
        if let Some(value) = problem.holds.iter().find_map(|hold| hold.until) {
            let (what, low) = ("when a support lets go [s]", problem.output.end);
            return Err(Refusal::OutOfRange { what, value, low, high: f64::INFINITY });
        }
        if let Some(index) = held.iter().position(Vec::is_empty) {
            return Err(Refusal::Idle { what: "support", number: index + 1 });
        }
        let still = vec![Vec3::zeros(); last + 1];
        let (displacement, velocity) = (still.clone(), still);
        let holds = problem.holds.clone();
        Ok(Self {
            along,
            pitch,
            section,
            places,
            masses,
            displacement,
            velocity,
            holds,
            held,
            pushed,
        })
    }

    pub(super) fn len(&self) -> usize {
        self.places.len()
    }

    /// 2/ω of its fastest mode: 2c/Δ along, 4 r c/Δ² across, r the greatest radius of gyration.
    pub(super) fn stable_step(&self) -> f64 {
        let s = &self.section;
        let speed = (s.young / s.density).sqrt();
        let across = (0..3).filter(|&axis| axis != self.along);
        let second = across.map(|axis| s.second[axis]).fold(0.0, f64::max);
        let radius = (second / s.area).sqrt();
        (self.pitch / speed).min(self.pitch * self.pitch / (2.0 * radius * speed))
    }

    pub(super) fn loads(&self) -> Vec<Vec3> {
        self.pushed.iter().map(|forces| forces.iter().sum()).collect()
    }

    /// Tension between a mass and the next \[N\].
    fn tension(&self, k: usize) -> f64 {
        let stretch = self.displacement[k + 1][self.along] - self.displacement[k][self.along];
        self.section.young * self.section.area * stretch / self.pitch
    }

    /// Whether the end at a mass is clamped: held across, and so is what lies beyond it.
    fn is_clamped(&self, k: usize, axis: usize) -> bool {
        self.held.iter().zip(&self.holds).any(|(held, hold)| hold.axes[axis] && held.contains(&k))
    }

    /// The turn at each mass along an axis across \[1\], and the stiffness of its spring \[N·m\].
    /// At a clamped end it is the turn of the first segment, by the half cell that is there.
    fn turns(&self, axis: usize) -> Vec<(f64, f64)> {
        let last = self.len() - 1;
        let slope =
            |k: usize| (self.displacement[k + 1][axis] - self.displacement[k][axis]) / self.pitch;
        let spring = self.section.young * self.section.second[axis] / self.pitch;
        (0..=last)
            .map(|k| match k {
                0 if self.is_clamped(0, axis) => (slope(0), 2.0 * spring),
                0 => (0.0, 0.0),
                k if k < last => (slope(k) - slope(k - 1), spring),
                _ if self.is_clamped(last, axis) => (-slope(last - 1), 2.0 * spring),
                _ => (0.0, 0.0),
            })
            .collect()
    }

    /// Forces of all springs \[N\].
    fn forces(&self) -> Vec<Vec3> {
        let last = self.len() - 1;
        let mut forces = vec![Vec3::zeros(); last + 1];
        for k in 0..last {
            let tension = self.tension(k);
            forces[k][self.along] += tension;
            forces[k + 1][self.along] -= tension;
        }
        for axis in (0..3).filter(|&axis| axis != self.along) {
            for (k, (turn, spring)) in self.turns(axis).into_iter().enumerate() {
                // −∂/∂w of ½ k φ², φ = (w₊ − w)/Δ − (w − w₋)/Δ.
                let push = spring * turn / self.pitch;
                if k < last {
                    forces[k + 1][axis] -= push;
                    forces[k][axis] += push;
                }
                if k > 0 {
                    forces[k - 1][axis] -= push;
                    forces[k][axis] += push;
                }
            }
        }
        forces
    }

    fn damp(&mut self, drive: &Drive<'_>) -> f64 {
        let half = 0.5 * drive.damping * drive.step;
        let share = (1.0 - half) / (1.0 + half);
        let kinetic = self.kinetic();
        self.velocity.iter_mut().for_each(|v| *v *= share);
        kinetic * (1.0 - share * share)
    }

    fn kinetic(&self) -> f64 {
        let pairs = self.velocity.iter().zip(&self.masses);
        0.5 * pairs.map(|(v, mass)| v.norm_squared() * mass).sum::<f64>()
    }

    /// Gives held masses their velocities; the work that this took \[J\], and the force of each
    /// support \[N\].
    fn hold(&mut self, drive: &Drive<'_>, before: &[Vec3]) -> (f64, Vec<Vec3>) {
        let mut wanted = vec![[None; 3]; self.len()];
        let active = self.held.iter().zip(&self.holds).zip(drive.holds);
        for ((held, hold), factor) in active {
            let Some(factor) = factor else { continue };
            for (&k, axis) in held.iter().flat_map(|k| (0..3).map(move |axis| (k, axis))) {
                let velocity = hold.velocity + hold.gradient * (self.places[k] - hold.centre);
                let sum = wanted[k][axis].unwrap_or(0.0) + factor * velocity[axis];
                wanted[k][axis] = hold.axes[axis].then_some(sum).or(wanted[k][axis]);
            }
        }
        let (mut work, mut reactions) = (0.0, vec![Vec3::zeros(); self.held.len()]);
        for (k, wanted) in wanted.iter().enumerate() {
            for (axis, velocity) in wanted.iter().enumerate() {
                let Some(velocity) = velocity else { continue };
                let push = (velocity - self.velocity[k][axis]) * self.masses[k];
                work += push * (before[k][axis] + velocity) / 2.0;
                self.velocity[k][axis] = *velocity;
                let first = |row: &(&Vec<usize>, &Hold)| row.0.contains(&k) && row.1.axes[axis];
                let first = self.held.iter().zip(&self.holds).position(|row| first(&row));
                first.into_iter().for_each(|support| {
                    reactions[support][axis] += push / drive.step;
                });
            }
        }
        (work, reactions)
    }
}

impl Discretisation for Chain {
    fn step(&mut self, drive: &Drive<'_>) -> StepTally {
        let damped = self.damp(drive);
        let before = self.velocity.clone();
        let mut loads = vec![Vec3::zeros(); self.len()];
        for (forces, factor) in self.pushed.iter().zip(drive.loads) {
            loads.iter_mut().zip(forces).for_each(|(sum, force)| *sum += force * *factor);
        }
        let springs = self.forces();
        for (k, v) in self.velocity.iter_mut().enumerate() {
            *v += (springs[k] + loads[k]) * (drive.step / self.masses[k]);
        }
        let (held, reactions) = self.hold(drive, &before);
        let ways = before.iter().zip(&self.velocity).zip(&loads);
        let pushed = ways.map(|((b, v), force)| force.dot(&(b + v)) / 2.0 * drive.step).sum();
        for (u, v) in self.displacement.iter_mut().zip(&self.velocity) {
            *u += v * drive.step;
        }
        StepTally { damped, pushed, held, reactions, ..StepTally::default() }
    }

    fn sums(&self) -> BodySums {
        let stiffness = self.section.young * self.section.area / self.pitch;
        let axial = (0..self.len() - 1).map(|k| self.tension(k).powi(2) / (2.0 * stiffness));
        let across = (0..3).filter(|&axis| axis != self.along);
        let bent = across.flat_map(|axis| self.turns(axis)).map(|(turn, k)| 0.5 * k * turn * turn);
        let momenta = || self.velocity.iter().zip(&self.masses).map(|(v, mass)| v * *mass);
        let moved = self.places.iter().zip(&self.displacement).map(|(x, u)| x + u);
        let state = self.displacement.iter().chain(&self.velocity);
        BodySums {
            kinetic: self.kinetic(),
            elastic: axial.sum::<f64>() + bent.sum::<f64>(),
            momentum: momenta().sum(),
            angular_momentum: moved.zip(momenta()).map(|(x, p)| x.cross(&p)).sum(),
            finite: state.flat_map(|v| v.iter()).all(|number| number.is_finite()),
        }
    }

    fn points(&self, fields: &[PointField]) -> PointFields {
        let last = self.len() - 1;
        let vectors = |all: &[Vec3]| {
            let local = |v: &Vec3| LocalVector { value: *v, gradient: Default::default() };
            FieldValues::Vectors(all.iter().map(local).collect())
        };
        let stress = |k: usize| {
            // The mean of both sides; an end has one.
            let sides = [k.max(1) - 1, k.min(last - 1)].map(|side| self.tension(side));
            let mut tensor = [0.0; 6];
            tensor[self.along] = (sides[0] + sides[1]) / (2.0 * self.section.area);
            tensor
        };
        let values = |field: PointField| match field {
            PointField::Displacement => Some(vectors(&self.displacement)),
            PointField::Velocity => Some(vectors(&self.velocity)),
            PointField::Stress => Some(FieldValues::Tensors((0..=last).map(stress).collect())),
            _ => None,
        };
        PointFields {
            places: self.places.clone(),
            numbers: (0..self.len() as u32).collect(),
            volumes: self.masses.iter().map(|mass| mass / self.section.density).collect(),
            fields: fields.iter().filter_map(|&f| Some((f, values(f)?))).collect(),
        }
    }

    fn pieces(&self) -> Vec<f64> {
        vec![1.0]
    }
}
