//! What presses on a shell: strikers through Hertz's contact, and what it rests on.

use super::schedule::ShellSchedule;
use crate::domain::ShellDomain;
use crate::midsurface::MidsurfacePoint;
use cullet_geometry::Vec3;
use cullet_model::hertz_contact::{self, HertzContact};
use cullet_model::{BrittleProblem, Impact, Material, Support};
use cullet_simd::Real;

/// Least radius of a loaded disc in cells: less is a point force on these cells.
const LEAST_CELLS: f64 = 1.5;

/// Durations of the contact after which it is over in any case, and apart after which it is.
const LONGEST: f64 = 6.0;
const APART: f64 = 0.5;

/// The same of what yields, over the longest push \[1\].
const METAL_APART: f64 = 0.04;

/// Greatest ω²Δt² that supports may add, of 4 at which central differences fail and 2.6 that the
/// shell takes \[1\].
const SUPPORTED: f64 = 0.03;

/// Points that something presses on.
#[derive(Clone, Debug)]
pub(super) struct PressedPoints {
    /// Middle, on the midsurface \[m\].
    pub(super) place: Vec3,
    /// Radius \[m\].
    pub(super) radius: f64,
    direction: Vec3,
    /// Points and their shares, 1 together.
    shares: Vec<(u32, f64)>,
    /// The same of control points, as long as none is split.
    nodes: Vec<(u32, f64)>,
    seen: Option<u64>,
}

/// A place moved along the normal of the point nearest to it, onto the plane of the midsurface
/// there.
fn onto_midsurface<R: Real, const N: usize>(domain: &ShellDomain<R, N>, place: Vec3) -> Vec3 {
    let points = domain.live().map(|p| domain.surface.surface_point(p));
    let far = |p: &MidsurfacePoint| (p.place - place).norm_squared();
    let nearest = points.min_by(|a, b| far(a).total_cmp(&far(b)));
    nearest.map_or(place, |p| place - p.normal * p.normal.dot(&(place - p.place)))
}

impl PressedPoints {
    /// A parabola over a disc; the nearest point where the disc has none.
    fn new<R: Real, const N: usize>(
        domain: &ShellDomain<R, N>,
        place: Vec3,
        direction: Vec3,
        radius: f64,
    ) -> Self {
        let place = onto_midsurface(domain, place);
        let far = |p: usize| (domain.surface.surface_point(p).place - place).norm_squared();
        let mut shares: Vec<(u32, f64)> = domain
            .live()
            .map(|p| (p as u32, (1.0 - far(p) / (radius * radius)) * domain.state(p).area))
            .filter(|share| share.1 > 0.0)
            .collect();
        if shares.is_empty() {
            let nearest = domain.live().min_by(|&a, &b| far(a).total_cmp(&far(b)));
            shares.extend(nearest.map(|p| (p as u32, 1.0)));
        }
        let all: f64 = shares.iter().map(|share| share.1).sum();
        shares.iter_mut().for_each(|share| share.1 /= all);
        Self { place, radius, direction, shares, nodes: Vec::new(), seen: None }
    }

    fn refresh<R: Real, const N: usize>(&mut self, domain: &ShellDomain<R, N>) {
        if self.seen == Some(domain.splits()) {
            return;
        }
        self.seen = Some(domain.splits());
        let mut all: Vec<(u32, f64)> = Vec::new();
        for &(point, share) in &self.shares {
            let (nodes, values) = domain.functions(point as usize);
            all.extend(nodes.iter().zip(values).map(|(&node, value)| (node, share * value)));
        }
        all.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        self.nodes.clear();
        for (node, share) in all {
            match self.nodes.last_mut() {
                Some(last) if last.0 == node => last.1 += share,
                _ => self.nodes.push((node, share)),
            }
        }
    }

    /// Speed of what is pressed along the direction \[m/s\].
    fn speed<R: Real, const N: usize>(&mut self, domain: &ShellDomain<R, N>) -> f64 {
        self.refresh(domain);
        let of = |&(node, share): &(u32, f64)| {
            share * domain.velocity[node as usize].dot(&self.direction)
        };
        self.nodes.iter().map(of).sum()
    }

    /// Speed of the whole body along the direction \[m/s\].
    fn speed_of_whole<R: Real, const N: usize>(&self, domain: &ShellDomain<R, N>) -> f64 {
        let pairs = domain.velocity.iter().zip(&domain.mass);
        let momentum: f64 = pairs.map(|(v, m)| v.dot(&self.direction) * m).sum();
        momentum / domain.mass.iter().sum::<f64>()
    }

    /// Presses with `force` \[N\] in the next step.
    fn press<R: Real, const N: usize>(&mut self, domain: &mut ShellDomain<R, N>, force: f64) {
        self.refresh(domain);
        for &(node, share) in &self.nodes {
            domain.external[node as usize] += self.direction * (force * share);
        }
    }
}

/// A rigid mass that moves along its push and presses through a [`HertzContact`].
#[derive(Clone, Debug)]
pub(super) struct ShellStriker {
    patch: PressedPoints,
    contact: HertzContact,
    /// Times after which it is over in any case, and apart after which it is \[s\].
    longest: [f64; 2],
    /// Whether it is not over while it comes on.
    follows: bool,
    closing_speed: f64,
    speed: f64,
    /// Speed that a unit impulse takes from it \[1/kg\].
    mobility: f64,
    approach: f64,
    delivered: f64,
    /// Most that it gives \[N·s\].
    impulse: f64,
    touched: f64,
    over: bool,
}

impl ShellStriker {
    /// Its mass follows from ½ m* v² = E and what the whole body moves by: 1/m* is the sum of the
    /// two mobilities.
    pub(super) fn new<R: Real, const N: usize>(
        hit: &Impact,
        problem: &BrittleProblem,
        domain: &ShellDomain<R, N>,
        thickness: f64,
        schedule: &ShellSchedule,
    ) -> Self {
        let contact = HertzContact::new(hit);
        let duration = hertz_contact::duration(hit);
        // What yields may part from it for a while, as it bends far.
        let follows = domain.law.hardening.is_some();
        let longest = match follows {
            true => [schedule.push, METAL_APART * schedule.push],
            false => [LONGEST, APART].map(|times| times * duration.min(schedule.push)),
        };
        let wanted = contact.radius(contact.depth(hit.energy)).max(0.5 * thickness);
        let cell = domain.surface.surface_point(0).extent;
        let radius = wanted.max(LEAST_CELLS * cell);
        let reduced = 2.0 * hit.energy / (hit.closing_speed * hit.closing_speed);
        let mobility = (1.0 / reduced - rigid_mobility(problem, hit)).max(0.0);
        Self {
            patch: PressedPoints::new(domain, hit.point, hit.normal, radius),
            contact,
            longest,
            follows,
            closing_speed: hit.closing_speed,
            speed: hit.closing_speed,
            mobility,
            approach: 0.0,
            delivered: 0.0,
            impulse: hit.impulse,
            touched: 0.0,
            over: false,
        }
    }

    pub(super) fn patch(&self) -> &PressedPoints {
        &self.patch
    }

    /// Impulse given so far \[N·s\].
    pub(super) fn delivered(&self) -> f64 {
        self.delivered
    }

    pub(super) fn is_over(&self) -> bool {
        self.over
    }

    /// Speed at which it still goes on, over that at first \[1\].
    pub(super) fn left(&self) -> f64 {
        self.speed / self.closing_speed
    }

    /// Energy that it has lost, less what its spring holds and what crushing took \[J\].
    pub(super) fn lost(&self) -> f64 {
        let lost = 0.5 * self.delivered * (self.closing_speed + self.speed);
        lost - self.contact.stored(self.approach.max(0.0)) - self.crushed()
    }

    /// Energy that crushing the contact took \[J\].
    pub(super) fn crushed(&self) -> f64 {
        self.contact.crushed()
    }

    pub(super) fn push<R: Real, const N: usize>(
        &mut self,
        domain: &mut ShellDomain<R, N>,
        time: f64,
    ) {
        if self.over {
            return;
        }
        let surface = self.patch.speed(domain);
        self.approach += (self.speed - surface) * domain.step;
        let force = self.contact.force(self.approach.max(0.0));
        let left = self.impulse - self.delivered;
        let size = (force * domain.step).min(left);
        if size > 0.0 {
            self.touched = time;
            self.delivered += size;
            self.speed -= size * self.mobility;
            self.patch.press(domain, size / domain.step);
        }
        let apart = time - self.touched > self.longest[1];
        self.over = size == left
            || time > self.longest[0]
            || apart && !(self.follows && self.speed > self.patch.speed_of_whole(domain));
    }
}

/// Velocity along the push that a unit impulse gives the whole body there: 1/m + n·[I⁻¹(r×n)]×r
/// \[1/kg\].
fn rigid_mobility(problem: &BrittleProblem, hit: &Impact) -> f64 {
    let whole = problem.solid.mesh.mass_properties();
    let arm = (hit.point - whole.centroid).cross(&hit.normal);
    let turned = whole.inertia.try_inverse().map_or(Vec3::zeros(), |inverse| inverse * arm);
    (1.0 / whole.volume + turned.dot(&arm)) / problem.material.density
}

/// A disc that holds the shell against moving into it, and lets it leave: as stiff as a half-space
/// of the shell's own material under a flat punch, k = 2aE/(1 − ν²).
#[derive(Clone, Debug)]
pub(super) struct ShellSupport {
    patch: PressedPoints,
    point: Vec3,
    stiffness: f64,
    mobility: f64,
    depth: f64,
    delivered: f64,
}

/// Softens supports that lie on one another, so that what they hold can be stepped: the greatest
/// ω² that they add is no more than the greatest Σ k w/m of a control point, by Gershgorin's
/// theorem, and k/m of what supports.
pub(super) fn soften<R: Real, const N: usize>(
    supports: &mut [ShellSupport],
    domain: &ShellDomain<R, N>,
) {
    let mut stiff = vec![0.0; domain.mass.len()];
    for support in supports.iter_mut() {
        support.patch.refresh(domain);
        for &(node, share) in &support.patch.nodes {
            stiff[node as usize] += support.stiffness * share;
        }
    }
    let most = SUPPORTED / (domain.step * domain.step);
    for support in supports {
        let at = |&(node, _): &(u32, f64)| stiff[node as usize] / domain.mass[node as usize];
        let shell = support.patch.nodes.iter().map(at).fold(0.0, f64::max);
        let all = shell + support.stiffness * support.mobility;
        support.stiffness *= (most / all).min(1.0);
    }
}

impl ShellSupport {
    pub(super) fn new<R: Real, const N: usize>(
        support: &Support,
        domain: &ShellDomain<R, N>,
        material: &Material,
        spacing: f64,
    ) -> Self {
        let radius = support.radius.max(LEAST_CELLS * spacing);
        let modulus = material.young / (1.0 - material.poisson * material.poisson);
        Self {
            patch: PressedPoints::new(domain, support.point, support.normal, radius),
            point: support.point,
            stiffness: 2.0 * radius * modulus,
            mobility: support.mobility,
            depth: 0.0,
            delivered: 0.0,
        }
    }

    /// Energy that it has taken from the shell, in its spring and in its motion \[J\].
    pub(super) fn stored(&self) -> f64 {
        let depth = self.depth.max(0.0);
        0.5 * (self.stiffness * depth * depth + self.mobility * self.delivered * self.delivered)
    }

    /// Where it pushes, and what it has given \[N·s\].
    pub(super) fn given(&self) -> (Vec3, Vec3) {
        (self.point, self.patch.direction * self.delivered)
    }

    pub(super) fn push<R: Real, const N: usize>(&mut self, domain: &mut ShellDomain<R, N>) {
        let speed = self.patch.speed(domain);
        let own = -self.mobility * self.delivered;
        self.depth -= (speed - own) * domain.step;
        // Of where the shell is now: a force that lags would feed it energy.
        let force = self.stiffness * self.depth.max(0.0);
        if force > 0.0 {
            self.delivered += force * domain.step;
            self.patch.press(domain, force);
        }
    }
}
