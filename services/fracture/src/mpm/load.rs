//! The striker's push: Hertz pressure on the contact disc, through the contact's spring.

use super::domain::Domain;
use super::load_patch::{LEAST_RADIUS, LoadPatch};
use cullet_geometry::Vec3;
use cullet_model::hertz_contact::{self, HertzContact};
use cullet_model::{Impact, Material};

/// Radius of the widest contact over the reach of the body from its centre: beyond, what is pressed
/// is no half-space.
const WIDEST: f64 = 0.5;

/// Durations of the contact after which it is over in any case.
const LONGEST: f64 = 3.0;

/// Durations apart after which the two have parted for good.
const APART: f64 = 0.5;

/// One impact: a striker that presses on points near the contact through a [`HertzContact`].
#[derive(Clone, Debug, PartialEq)]
pub struct ImpactLoad {
    /// The points that it presses on.
    pub patch: LoadPatch,
    /// Where \[m\].
    pub point: Vec3,
    /// Radius of the loaded disc \[m\].
    pub radius: f64,
    /// Direction of the push.
    pub direction: Vec3,
    /// Most that the striker gives \[N·s\].
    pub impulse: f64,
    /// How long the contact of a rigid body would take \[s\].
    pub duration: f64,
    /// How far it has come \[N·s\].
    pub delivered: f64,
    /// Work done on the body so far \[J\].
    pub work: f64,
    /// Force now \[N\].
    pub force: f64,
    contact: HertzContact,
    striker: RigidStriker,
    state: PushState,
}

/// How far a push is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct PushState {
    /// Given in the last step \[N·s\].
    last: f64,
    /// Speed of the surface before that \[m/s\].
    surface: f64,
    /// When the two last touched \[s\].
    touched: f64,
    over: bool,
}

/// The striker, as a mass that moves along the push.
#[derive(Clone, Copy, Debug, PartialEq)]
struct RigidStriker {
    /// Its speed at first, seen from the body at rest \[m/s\].
    closing_speed: f64,
    /// The same now \[m/s\].
    speed: f64,
    /// Speed that a unit impulse takes from it \[1/kg\].
    mobility: f64,
    /// Approach of striker and body since they touched, δ \[m\].
    approach: f64,
}

impl ImpactLoad {
    /// Spreads `impact` over the points of `domain` near it, for a contact of `duration` \[s\].
    ///
    /// `mobility` is the body's at the contact, 1/m + n·[I⁻¹(r×n)]×r \[1/kg\]; the striker's
    /// follows from ½ m* v² = E. A `duration` shorter by s is that of a striker of the same energy
    /// with m* s² and v/s: same spring, same peak force, s times the impulse.
    #[must_use]
    pub fn new(impact: &Impact, domain: &Domain, duration: f64, mobility: f64) -> Self {
        let contact = HertzContact::new(impact);
        let reach = domain.particles.reference.iter().map(Vec3::norm).fold(0.0, f64::max);
        let widest = impact.radius.max(WIDEST * reach);
        let radius = contact.radius(contact.depth(impact.energy)).min(widest);
        let share = duration / hertz_contact::duration(impact);
        let reduced = 2.0 * impact.energy / (impact.closing_speed * impact.closing_speed);
        Self {
            patch: LoadPatch::on_disc(domain, &impact.point, &impact.normal, radius),
            point: impact.point,
            radius: radius.max(LEAST_RADIUS * domain.grid.spacing.max()),
            direction: impact.normal,
            impulse: share * impact.impulse,
            duration,
            delivered: 0.0,
            work: 0.0,
            force: 0.0,
            contact,
            striker: RigidStriker {
                closing_speed: impact.closing_speed / share,
                speed: impact.closing_speed / share,
                // 1/m* is the sum of the two mobilities [Gate 0]
                mobility: (1.0 / (reduced * share * share) - mobility).max(0.0),
                approach: 0.0,
            },
            state: PushState::default(),
        }
    }

    /// Whether the tension at the rim of a contact that is too narrow for the grid has reached the
    /// strength.
    ///
    /// σ_r = (1 − 2ν) p₀/3 with p₀ = 3F/2πa² (H1); a field only a/10 deep counts in proportion to
    /// √(a/10) where that is less than the material's EG_f/σ_f² [Gate 2].
    #[must_use]
    pub fn cracks(&self, material: &Material) -> bool {
        let radius = self.contact.widest();
        let area = 2.0 * core::f64::consts::PI * radius * radius;
        let rim = (1.0 - 2.0 * material.poisson) * self.force / area;
        let strength = material.failure_stress;
        let process = material.young * material.fracture_energy / (strength * strength);
        let depth = 0.1 * radius;
        self.force > 0.0 && rim * (depth / process.max(depth)).sqrt() >= strength
    }

    /// Greatest radius of the contact so far, were it not widened \[m\].
    #[must_use]
    pub fn contact_radius(&self) -> f64 {
        self.contact.widest()
    }

    /// Greatest force so far \[N\].
    #[must_use]
    pub fn peak(&self) -> f64 {
        self.contact.greatest()
    }

    /// Whether an approach of that energy \[J\] crushes the contact.
    #[must_use]
    pub fn will_crush(&self, energy: f64) -> bool {
        self.contact.crushes(energy)
    }

    /// How deep the cap is that the contact has pressed in so far, a²/R \[m\].
    #[must_use]
    pub fn depth_of_cap(&self) -> f64 {
        let radius = self.contact.widest();
        radius * radius / self.contact.relative_radius()
    }

    /// Energy that crushing of the contact has taken so far \[J\].
    #[must_use]
    pub fn crushing_energy(&self) -> f64 {
        self.contact.crushed()
    }

    /// Whether nothing more is to come.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.state.over
    }

    /// Pushes the body by what falls into the domain's next step.
    ///
    /// The force is the spring's: it ends when the body gives way or the two part, so no push does
    /// more work than the striker loses (F12), nor gives more than `impulse`.
    pub fn push(&mut self, domain: &mut Domain) {
        self.state.last = 0.0;
        if self.state.over {
            return;
        }
        let surface = self.patch.speed(domain, &self.direction);
        self.state.surface = surface;
        self.striker.approach += (self.striker.speed - surface) * domain.step;
        self.force = self.contact.force(self.striker.approach.max(0.0));
        let left = self.impulse - self.delivered;
        let size = (self.force * domain.step).min(left);
        if size > 0.0 {
            self.state.touched = domain.time;
        }
        self.state.over = size == left
            || domain.time > LONGEST * self.duration
            || domain.time - self.state.touched > APART * self.duration;
        self.state.last = size;
        if size > 0.0 {
            self.delivered += size;
            self.striker.speed -= size * self.striker.mobility;
            self.patch.push(domain, self.direction * size);
        }
    }

    /// Books the work of the push in the step that was just taken: at the mean of the surface's
    /// speeds before and after it, which is what it did, whatever else pushed there.
    pub fn book(&mut self, domain: &Domain) {
        if self.state.last > 0.0 {
            let after = self.patch.speed(domain, &self.direction);
            self.work += 0.5 * self.state.last * (self.state.surface + after);
        }
    }
}
