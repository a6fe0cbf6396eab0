//! Cracks go on: points that have broken part their links, and points ahead of a tip have the
//! strength that lets a crack run at G_f.

use super::state::ShellDomain;
use cullet_geometry::Vec3;
use cullet_simd::Real;

/// σ_t = k √(2EG_f/1.1 l): starts a crack at G = 1.1–1.3 G_f for k = 0.5–0.6  \[measured\].
pub const TIP_FACTOR: f64 = 0.6;

/// How far ahead of a broken point its tip is felt, in cells, and the cone that is ahead, |d·n̂|
/// over |d|: all round, cracks would widen (F100).
const AHEAD: (f64, f64) = (1.5, 0.6);

/// Rings of neighbours that reach that far.
const RINGS: usize = 4;

impl<R: Real, const N: usize> ShellDomain<R, N> {
    /// Strength ahead of a tip whose crack opens in its plane, in cells of an extent of `extent`
    /// \[m\] across it \[Pa\]. In bending by the share β it is 1/√s(β) times that.
    #[must_use]
    pub fn tip_strength(&self, extent: f64) -> f64 {
        let toughness = 2.0 * self.law.material.young * self.law.material.fracture_energy;
        TIP_FACTOR * (toughness / (1.1 * extent)).sqrt()
    }

    /// Breaks a point across `normal` (in its frame) before anything has moved: a notch. Points
    /// ahead feel its tip after [`ShellDomain::wake_tips`].
    pub fn notch(&mut self, point: usize, normal: [f64; 2]) {
        let law = self.law.clone();
        self.change(point, |state| state.cut(&law, normal));
        self.sever(point);
    }

    /// Before the points' pass: parts control points and lets points feel the tips near them.
    pub(crate) fn go_on(&mut self) {
        self.front.steps += 1;
        let later = self.front.due.split_off(&(self.front.steps + 1));
        for (_, points) in std::mem::replace(&mut self.front.due, later) {
            for (point, strength) in points {
                if !self.is_on(point as usize) {
                    continue;
                }
                let state = &self.states[self.seats[point as usize]];
                let strength = strength * state.score;
                // Where no flaw can start a crack none can run either.
                let weaker = state.tip > strength && state.flaw.is_finite();
                if state.crack.is_none() && weaker {
                    self.change(point as usize, |state| state.tip = strength);
                }
            }
        }
        if !self.front.changed.is_empty() {
            let changed = std::mem::take(&mut self.front.changed);
            self.part(&changed);
            self.crumble(&changed);
        }
    }

    /// Broken points that are of no part hold nothing together any more.
    fn crumble(&mut self, changed: &[u32]) {
        let beside = |&p: &u32| self.surface.around(p as usize).iter().copied().chain([p]);
        let mut near: Vec<u32> = changed.iter().flat_map(beside).collect();
        near.sort_unstable();
        near.dedup();
        for point in near {
            let p = point as usize;
            let is_crumb = self.is_on(p)
                && self.state(p).is_broken()
                && !self.links.is_part(&self.surface, point);
            if is_crumb {
                self.change(p, |state| state.crumbles = true);
            }
        }
    }

    /// After the points' pass, where points have broken.
    pub(crate) fn note_broken(&mut self) {
        for point in self.live() {
            let state = &self.states[self.seats[point]];
            let (broken, dead, crossed) = (state.is_broken(), state.dead, state.crossed);
            if broken && self.links.facing(point).norm_squared() == 0.0 {
                self.parted(point);
            }
            if dead && crossed {
                self.cross(point);
            } else if dead && self.links.kill(&self.surface, point) {
                self.front.changed.push(point as u32);
            }
        }
    }

    /// Severs the links of a point that has broken, and announces its tip.
    fn parted(&mut self, point: usize) {
        self.front.times.insert(point as u32, self.front.steps);
        self.sever(point);
        self.announce(point);
    }

    /// Severs the links across the second crack of a point, once.
    fn cross(&mut self, point: usize) {
        if self.links.second(point).norm_squared() > 0.0 {
            return;
        }
        let Some(crack) = self.states[self.seats[point]].crack else { return };
        let along = [-crack.normal[1], crack.normal[0]];
        let parted = self.links.break_point(&self.surface, point, along);
        let facing = self.links.second(point);
        self.sides.extend(point as u32, &parted, &facing, &self.links);
        self.front.changed.push(point as u32);
    }

    /// Severs the links of a point that has broken.
    fn sever(&mut self, point: usize) {
        let Some(crack) = self.states[self.seats[point]].crack else { return };
        let parted = self.links.break_point(&self.surface, point, crack.normal);
        let facing = self.links.facing(point);
        self.sides.extend(point as u32, &parted, &facing, &self.links);
        self.front.changed.push(point as u32);
    }

    /// Lets points feel all tips that there are, at once: after a change of strengths.
    pub fn wake_tips(&mut self) {
        let points = 0..self.seats.len();
        let broken: Vec<usize> =
            points.filter(|&p| self.links.facing(p).norm_squared() > 0.0).collect();
        broken.into_iter().for_each(|point| self.announce(point));
    }

    /// Lets the points ahead of one that has broken feel its tip in due time.
    fn announce(&mut self, point: usize) {
        let Some(crack) = self.states[self.seats[point]].crack else { return };
        let facing = self.links.facing(point);
        self.announce_across(point, crack.normal, &facing);
    }

    /// The same of a point that something has parted across `normal` (in its frame), `facing` in
    /// space.
    pub(super) fn announce_across(&mut self, point: usize, normal: [f64; 2], facing: &Vec3) {
        let at = self.setup[self.seats[point]].surface;
        let strength = self.tip_strength(at.extent_along(normal));
        let [e1, e2] = at.frame();
        let place = self.links.place(point);
        let pace = self.step * self.law.material.rayleigh_speed();
        for other in self.near(point) {
            let away = self.links.place(other as usize) - place;
            let far = away.norm();
            let extent = at.extent_along([away.dot(&e1) / far, away.dot(&e2) / far]);
            if far <= AHEAD.0 * extent && away.dot(facing).abs() <= AHEAD.1 * far {
                let due = self.front.steps + 1 + (far / pace) as u64;
                self.front.due.entry(due).or_default().push((other, strength));
            }
        }
    }

    /// When a point broke \[s\]; infinite where it has not.
    #[must_use]
    pub fn broken_at(&self, point: usize) -> f64 {
        self.front.times.get(&(point as u32)).map_or(f64::INFINITY, |&step| step as f64 * self.step)
    }

    /// Unit normal of the crack at a broken point; zero elsewhere.
    #[must_use]
    pub fn crack_normal(&self, point: usize) -> Vec3 {
        self.links.facing(point)
    }

    /// The points beside one, and whether something joins each to it.
    pub fn joined(&self, point: usize) -> impl Iterator<Item = (usize, bool)> + '_ {
        let first = self.surface.starts[point] as usize;
        let around = self.surface.around(point).iter().enumerate();
        around.map(move |(k, &q)| (q as usize, self.links.is_whole(first + k)))
    }

    /// The part that each point is of, from 0 on: what whole links join. None for broken points and
    /// for those of parts of fewer than `least` points.
    #[must_use]
    pub fn parts(&self, least: usize) -> Vec<Option<u32>> {
        let is_whole =
            |p: usize| self.is_on(p) && !self.state(p).is_broken() && !self.state(p).dead;
        let mut part: Vec<Option<u32>> = vec![None; self.points()];
        let mut seen = vec![false; self.points()];
        let mut count = 0;
        for start in (0..self.points()).filter(|&p| is_whole(p)) {
            if std::mem::replace(&mut seen[start], true) {
                continue;
            }
            let mut found = vec![start];
            let mut next = 0;
            while next < found.len() {
                let p = found[next];
                next += 1;
                for (k, &q) in self.surface.around(p).iter().enumerate() {
                    let (entry, q) = (self.surface.starts[p] as usize + k, q as usize);
                    if self.links.is_whole(entry) && is_whole(q) && !seen[q] {
                        seen[q] = true;
                        found.push(q);
                    }
                }
            }
            if found.len() >= least {
                found.into_iter().for_each(|p| part[p] = Some(count));
                count += 1;
            }
        }
        part
    }

    /// The points a few rings of neighbours around one, ascending.
    fn near(&self, point: usize) -> Vec<u32> {
        let mut found = vec![point as u32];
        let mut first = 0;
        for _ in 0..RINGS {
            let ring = first..found.len();
            first = ring.end;
            for at in ring {
                for &q in self.surface.around(found[at] as usize) {
                    if !found.contains(&q) {
                        found.push(q);
                    }
                }
            }
        }
        found.remove(0);
        found.sort_unstable();
        found
    }
}
