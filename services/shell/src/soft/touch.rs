//! How a soft shell meets rigid bodies: at its points, whose forces go to control points by their
//! functions, so that force and moment are exact.

use crate::domain::ShellDomain;
use cullet_continuum::{RigidProxy, TouchedPoints};
use cullet_geometry::Vec3;

/// How far beyond the contact points are looked for, in spacings: until they may have come that
/// much closer, no others are.
const MARGIN: f64 = 1.0;

/// The points that rigid bodies may touch.
#[derive(Clone, Debug, Default)]
pub(super) struct TouchablePoints {
    points: Vec<u32>,
    /// How far they may still come closer until they are found anew \[m\].
    left: f64,
    is_found: bool,
    places: Vec<Vec3>,
    velocities: Vec<Vec3>,
    masses: Vec<[f64; 2]>,
    frozen: Vec<bool>,
    forces: Vec<Vec3>,
}

/// What touching goes by.
#[derive(Clone, Copy, Debug)]
pub(super) struct TouchInput<'a> {
    /// Mass of each point \[kg\].
    pub(super) masses: &'a [f64],
    pub(super) gravity: Vec3,
    /// Distance below which a point touches \[m\].
    pub(super) distance: f64,
    pub(super) spacing: f64,
    pub(super) dt: f64,
    /// Speed of the fastest control point \[m/s\].
    pub(super) fastest: f64,
}

impl TouchablePoints {
    /// Finds points anew at the next step.
    pub(super) fn forget(&mut self) {
        self.is_found = false;
    }

    /// Adds what rigid bodies do to control points to `forces` \[N\], and kicks the bodies.
    pub(super) fn touch<const N: usize>(
        &mut self,
        domain: &ShellDomain<f64, N>,
        proxies: &mut [RigidProxy],
        frozen: impl Fn(u32) -> bool,
        input: &TouchInput<'_>,
        forces: &mut [Vec3],
    ) {
        if proxies.is_empty() {
            return;
        }
        let quickest = proxies.iter().map(RigidProxy::speed).fold(0.0, f64::max);
        self.left -= (quickest + input.fastest) * input.dt;
        if !self.is_found || self.left.is_nan() || self.left < 0.0 {
            self.find(domain, proxies, input);
        }
        let all = self.points.iter();
        self.places.clear();
        self.places.extend(all.clone().map(|&p| domain.place_now(p as usize)));
        self.velocities.clear();
        let velocity = |&p: &u32| domain.interpolate(p as usize, &domain.velocity);
        self.velocities.extend(all.clone().map(velocity));
        self.masses.clear();
        self.masses.extend(all.clone().map(|&p| [input.masses[p as usize]; 2]));
        self.frozen.clear();
        self.frozen.extend(all.map(|&p| frozen(p)));
        self.forces.clear();
        self.forces.resize(self.points.len(), Vec3::zeros());
        let points = TouchedPoints {
            places: &self.places,
            velocities: &self.velocities,
            masses: &self.masses,
            frozen: &self.frozen,
            distance: input.distance,
            dt: input.dt,
        };
        for proxy in proxies {
            proxy.touch(&points, input.gravity, &mut self.forces);
        }
        for (&p, force) in self.points.iter().zip(&self.forces) {
            if *force != Vec3::zeros() {
                let (nodes, shares) = domain.functions(p as usize);
                for (&node, share) in nodes.iter().zip(shares) {
                    forces[node as usize] += force * *share;
                }
            }
        }
    }

    fn find<const N: usize>(
        &mut self,
        domain: &ShellDomain<f64, N>,
        proxies: &[RigidProxy],
        input: &TouchInput<'_>,
    ) {
        self.is_found = true;
        self.left = MARGIN * input.spacing;
        let margin = input.distance + self.left;
        let is_near = |p: &usize| {
            let place = domain.place_now(*p);
            proxies.iter().any(|proxy| {
                let (centre, radius) = proxy.reach();
                (place - centre).norm_squared() <= (radius + margin) * (radius + margin)
            })
        };
        let live = domain.live().filter(|&p| !domain.state(p).dead);
        self.points = live.filter(is_near).map(|p| p as u32).collect();
    }
}
