//! What a point of a brittle shell carries, and its step.

use super::plane::{principal, turned, turned_back};
use super::yielding::{StationFlow, less};
use super::{BROKEN, SectionLaw, SectionTally, bending_scale};
use crate::kernel::{PlaneStress, Resultants, SurfaceStrain};

/// The crack of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrackLine {
    /// Unit normal n̂ of the crack in the point's frame (e₁, e₂).
    pub normal: [f64; 2],
    /// Share of bending in what opened it, β \[1\].
    pub bending_share: f64,
    /// Sign of κ_nn at onset: the side of the thickness that opened first.
    pub side: f64,
    /// How it softens under the stress of the worst station.
    pub(crate) worst: CrackSoftening,
    /// How it softens under the mean stress, so that what opens it costs no more than G_f.
    pub(crate) mean: CrackSoftening,
}

/// c = (1 + H)(1 − σ_f/σ̄) of a crack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CrackSoftening {
    /// H \[1\].
    pub(crate) hardness: f64,
    /// σ_f \[Pa\].
    pub(crate) strength: f64,
}

impl CrackSoftening {
    /// c under σ̄ \[Pa\].
    pub(super) fn damage(&self, stress: f64) -> f64 {
        (1.0 + self.hardness) * (1.0 - self.strength / stress)
    }
}

/// What a point carries.
#[derive(Clone, Debug, PartialEq)]
pub struct PointState {
    /// c \[0, 1\].
    pub damage: f64,
    /// Its crack, from onset on.
    pub crack: Option<CrackLine>,
    /// Whether a second crack has taken all that was left.
    pub dead: bool,
    /// Whether that crack runs along the normal of the first.
    pub crossed: bool,
    /// Whether it is of a crumb, too small to be a part: what it holds goes with the next step.
    pub crumbles: bool,
    /// Strength of the material here \[Pa\].
    pub flaw: f64,
    /// Strength ahead of a tip, in the plane; infinite where there is none \[Pa\].
    pub tip: f64,
    /// Toughness (K_Ic) below a scored line over that of the material \[1\]: 1 where there is none.
    pub score: f64,
    /// Components 11, 22, 12 of what l_c² = n̂·S n̂ across a crack comes from \[m²\].
    pub spread: [f64; 3],
    /// t \[m\].
    pub thickness: f64,
    /// Area of the midsurface \[m²\].
    pub area: f64,
    /// What has flowed at each station; empty where nothing has.
    pub flow: Vec<StationFlow>,
    /// Of a soft wall: the strain at which it healed behind a cut, from where it is whole.
    pub set: Option<SurfaceStrain>,
    /// How far its stations were from yielding when they were last looked at \[Pa\].
    pub(super) slack: f64,
    /// Strain of the last step in which it was not simply elastic, nor far from yielding.
    pub(crate) last: Option<SurfaceStrain>,
}

impl PointState {
    /// A whole point.
    #[must_use]
    pub fn new(flaw: f64, spread: [f64; 3], thickness: f64, area: f64) -> Self {
        let (damage, crack, dead, crossed, crumbles) = (0.0, None, false, false, false);
        let (tip, flow, slack, last) = (f64::INFINITY, Vec::new(), 0.0, None);
        let (set, score) = (None, 1.0);
        Self {
            damage,
            crack,
            dead,
            crossed,
            crumbles,
            flaw,
            tip,
            score,
            spread,
            thickness,
            area,
            flow,
            set,
            slack,
            last,
        }
    }

    /// Breaks it across `normal` before it has borne anything.
    pub fn cut(&mut self, law: &SectionLaw, normal: [f64; 2]) {
        let (strength, bending_share, side) = (self.in_force(0.0), 0.0, 1.0);
        let worst = law.softens(strength, self.length(normal), bending_share);
        self.crack = Some(CrackLine { normal, bending_share, side, worst, mean: worst });
        self.damage = 1.0;
    }

    /// l_c of a crack with that unit normal in the point's frame \[m\].
    #[must_use]
    pub fn length(&self, normal: [f64; 2]) -> f64 {
        turned(&self.spread, normal)[0].sqrt()
    }

    /// Strength against a crack that opens in bending by the share β: that of the material, or
    /// ahead of a tip σ_t/√s(β) where that is less \[Pa\].
    #[must_use]
    pub fn in_force(&self, bending_share: f64) -> f64 {
        self.flaw.min(self.tip / bending_scale(bending_share).sqrt())
    }

    /// What of a strain at a station has not flowed.
    fn elastic_part(&self, station: usize, strain: &[f64; 3]) -> [f64; 3] {
        self.flow.get(station).map_or(*strain, |flow| less(strain, &flow.strain))
    }

    /// Whether it bears nothing across its crack.
    #[must_use]
    pub fn is_broken(&self) -> bool {
        self.damage >= BROKEN
    }
}

/// A stiffness of a cracked section.
struct CrackedSection {
    /// f = E/(1 − ν²).
    across: f64,
    young: f64,
    poisson: f64,
    /// 2μ.
    shear: f64,
}

impl CrackedSection {
    fn new(law: &SectionLaw) -> Self {
        let PlaneStress { modulus, poisson } = law.elastic;
        Self {
            across: modulus,
            young: law.material.young,
            poisson,
            shear: modulus * (1.0 - poisson),
        }
    }

    /// e = ε_nn + νε_tt.
    fn opening(&self, e: &[f64; 3]) -> f64 {
        e[0] + self.poisson * e[1]
    }

    /// e² of the opening alone that has the energy of opening and sliding; 0 where it is closed.
    fn drive(&self, e: &[f64; 3]) -> f64 {
        let opening = self.opening(e);
        if opening <= 0.0 {
            return 0.0;
        }
        opening * opening + 2.0 * self.shear / self.across * e[2] * e[2]
    }

    /// What a damage of c takes of the stress across the crack and of the shear: all once the point
    /// is cut, whatever the sign, for its sides meet by contact (F81).
    fn left(&self, damage: f64, opening: f64) -> (f64, f64) {
        match damage {
            c if c >= BROKEN => (0.0, 0.0),
            c if opening > 0.0 => (1.0 - c, 1.0 - c),
            c => (1.0, 1.0 - c),
        }
    }

    /// nn, tt, nt.
    fn stress(&self, e: &[f64; 3], damage: f64) -> [f64; 3] {
        let opening = self.opening(e);
        let (pull, slide) = self.left(damage, opening);
        let across = pull * self.across * opening;
        [across, self.young * e[1] + self.poisson * across, slide * self.shear * e[2]]
    }

    /// ψ \[J/m³\].
    fn energy(&self, e: &[f64; 3], damage: f64) -> f64 {
        let opening = self.opening(e);
        let (pull, slide) = self.left(damage, opening);
        0.5 * (self.young * e[1] * e[1] + pull * self.across * opening * opening)
            + slide * self.shear * e[2] * e[2]
    }
}

impl SectionLaw {
    /// What the section of a point bears under `strain`; its damage grows, if it does, first.
    pub fn step(
        &self,
        state: &mut PointState,
        strain: &SurfaceStrain,
        tally: &mut SectionTally,
    ) -> Resultants {
        if let Some(soft) = &self.soft {
            return self.tear(soft, state, strain, tally);
        }
        if let Some(hardening) = &self.hardening {
            return self.flow(hardening, state, strain, tally);
        }
        if state.dead {
            return Resultants::default();
        }
        if state.crack.is_none() {
            self.open(state, strain);
        }
        if let Some(crack) = state.crack
            && !state.is_broken()
        {
            self.grow(state, &crack, strain, tally);
        }
        if state.is_broken() {
            self.cross(state, strain, tally);
        }
        state.last = Some(*strain);
        self.borne(state, strain)
    }

    /// The softening of a crack that opens in bending by the share β.
    fn softens(&self, strength: f64, length: f64, bending_share: f64) -> CrackSoftening {
        let hardness = self.softening(strength, length, bending_share);
        CrackSoftening { hardness, strength }
    }

    /// The two stresses that open a crack with that normal \[Pa\]. The greatest of a station's
    /// across it; and the mean f ē, ē² that of e² + 2(1 − ν)e_nt² over the stations that are open:
    /// the stress in the plane that has their energy.
    fn drives(&self, normal: [f64; 2], t: f64, strain: &SurfaceStrain) -> (f64, f64) {
        let cracked = CrackedSection::new(self);
        let (mut worst, mut mean) = (0.0_f64, 0.0);
        for &(z, w) in self.stations.list() {
            let e = turned(&strain.at(z * t), normal);
            worst = worst.max(cracked.opening(&e));
            mean += w * cracked.drive(&e);
        }
        (cracked.across * worst, cracked.across * mean.sqrt())
    }

    /// Opens a crack where the worst face bears more than the strength.
    fn open(&self, state: &mut PointState, strain: &SurfaceStrain) {
        let face = 0.5 * state.thickness;
        let at = |z: f64| self.elastic.stress(&strain.at(z));
        let faces = [face, -face].map(|z| principal(&at(z)));
        let (worst, normal) = if faces[1].0 > faces[0].0 { faces[1] } else { faces[0] };
        if worst <= state.in_force(0.0) {
            return;
        }
        let middle = turned(&at(0.0), normal)[0].max(0.0);
        let bending_share = (1.0 - middle / worst).clamp(0.0, 1.0);
        let strength = state.in_force(bending_share);
        if worst <= strength {
            return;
        }
        let side = turned(&strain.bending, normal)[0].signum();
        let length = state.length(normal);
        // The mean stress when the worst face bore the strength.
        let mean = self.drives(normal, state.thickness, strain).1 * strength / worst;
        let softens = |strength: f64, share: f64| CrackSoftening {
            // A crack costs the square of the score of G_f.
            hardness: self.softening(strength / state.score, length, share),
            strength,
        };
        let (worst, mean) = (softens(strength, bending_share), softens(mean, 0.0));
        state.crack = Some(CrackLine { normal, bending_share, side, worst, mean });
    }

    /// c = max(c, (1 + H)(1 − σ_f/σ̄)), of the stress of the worst station and of the mean: alone,
    /// the first makes a crack that started in bending and is then torn in the plane cost up to 4.5
    /// G_f, and one that slides too. Closed it does not grow.
    fn grow(
        &self,
        state: &mut PointState,
        crack: &CrackLine,
        strain: &SurfaceStrain,
        tally: &mut SectionTally,
    ) {
        let cracked = CrackedSection::new(self);
        let t = state.thickness;
        let (worst, mean) = self.drives(crack.normal, t, strain);
        if worst <= 0.0 {
            return;
        }
        let wanted = crack.worst.damage(worst).max(crack.mean.damage(mean));
        let growth = (wanted.min(1.0) - state.damage).min(self.most_growth);
        if growth <= 0.0 || growth.is_nan() {
            return;
        }
        // What damage takes is taken in the middle of the step: at its end it would be too much.
        let middle = state.last.map_or(*strain, |last| last.middle(strain));
        let stored = |damage: f64| -> f64 {
            let local = |z: f64| turned(&middle.at(z * t), crack.normal);
            let at = |&(z, w): &(f64, f64)| w * cracked.energy(&local(z), damage);
            self.stations.list().iter().map(at).sum()
        };
        let before = stored(state.damage);
        state.damage += growth;
        if state.damage >= BROKEN {
            state.damage = 1.0;
            tally.broken += 1;
        }
        tally.dissipated += state.area * t * (before - stored(state.damage));
    }

    /// A second crack across the first takes what is left; so does a strain that no brittle section
    /// has, and the end of a crumb.
    fn cross(&self, state: &mut PointState, strain: &SurfaceStrain, tally: &mut SectionTally) {
        let Some(crack) = state.crack else { return };
        let cracked = CrackedSection::new(self);
        let t = state.thickness;
        let local = |z: f64| turned(&strain.at(z * t), crack.normal);
        let along = |&(z, _): &(f64, f64)| cracked.stress(&local(z), 1.0)[1];
        let worst = self.stations.list().iter().map(along).fold(0.0, f64::max);
        let face = 0.5 * t;
        let strained = [face, -face].into_iter().flat_map(|z| strain.at(z));
        let is_lost = strained.fold(0.0_f64, |most, e| most.max(e.abs())) > self.most_strain;
        if worst > state.flaw || state.crumbles || is_lost {
            tally.dissipated += state.area * self.energy(state, strain);
            tally.broken += 1;
            state.dead = true;
            state.crossed = worst > state.flaw;
        }
    }

    /// Resultants of a state.
    #[must_use]
    pub fn borne(&self, state: &PointState, strain: &SurfaceStrain) -> Resultants {
        if let Some(soft) = &self.soft {
            return self.soft_borne(soft, state, strain);
        }
        let mut borne = Resultants::default();
        if state.dead {
            return borne;
        }
        let (t, cracked) = (state.thickness, CrackedSection::new(self));
        for (station, &(z, w)) in self.stations.list().iter().enumerate() {
            let e = strain.at(z * t);
            let s = match &state.crack {
                None => self.elastic.stress(&state.elastic_part(station, &e)),
                Some(crack) => {
                    let local = cracked.stress(&turned(&e, crack.normal), state.damage);
                    turned_back(&local, crack.normal)
                }
            };
            borne.add(t, (z, w), &s);
        }
        borne
    }

    /// Elastic energy of a point over its area \[J/m²\].
    #[must_use]
    pub fn energy(&self, state: &PointState, strain: &SurfaceStrain) -> f64 {
        if let Some(soft) = &self.soft {
            return self.soft_energy(soft, state, strain);
        }
        if state.dead {
            return 0.0;
        }
        let (t, cracked) = (state.thickness, CrackedSection::new(self));
        let at = |(station, &(z, w)): (usize, &(f64, f64))| {
            let e = strain.at(z * t);
            let energy = match &state.crack {
                None => self.elastic.energy(&state.elastic_part(station, &e)),
                Some(crack) => cracked.energy(&turned(&e, crack.normal), state.damage),
            };
            w * t * energy
        };
        self.stations.list().iter().enumerate().map(at).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::PointState;
    use crate::kernel::SurfaceStrain;
    use crate::section::{SectionLaw, SectionTally, bending_scale, lobatto};
    use cullet_model::Material;

    fn glass(stations: usize) -> SectionLaw {
        let material = Material {
            density: 2500.0,
            young: 70e9,
            poisson: 0.22,
            failure_stress: 30e6,
            fracture_energy: 8.0,
        };
        let law = SectionLaw::new(&material);
        SectionLaw { stations: lobatto(stations), most_growth: 1e-3, ..law }
    }

    /// Work of a section over G_f t that is bent until it is broken, nothing pulling in its plane.
    fn bent(stations: usize, share: f64) -> f64 {
        let law = glass(stations);
        let (t, strength) = (3e-3, 30e6);
        let length = share * 2.0 * 70e9 * 8.0 / (strength * strength) / bending_scale(1.0);
        let mut state = PointState::new(strength, [length * length, length * length, 0.0], t, 1.0);
        let mut tally = SectionTally::default();
        let mut strain = SurfaceStrain::default();
        let mut face = 0.0;
        while !state.is_broken() {
            // The strained face leads, for the curvature may go back; n = 0 by bisection.
            face += 1e-4 * strength / 70e9;
            let (mut low, mut high) = (0.0, 4.0 * face / t);
            for _ in 0..60 {
                strain.bending[0] = 0.5 * (low + high);
                strain.membrane[0] = face - 0.5 * t * strain.bending[0];
                let pulls = law.borne(&state, &strain).force[0] > 0.0;
                *(if pulls { &mut low } else { &mut high }) = strain.bending[0];
            }
            law.step(&mut state, &strain, &mut tally);
        }
        // A band l_c wide of points of area 1 takes this for a crack of length 1/l_c.
        tally.dissipated * length / (8.0 * t)
    }

    /// S21: once the softening length is scaled by 1 − 0.78 β, a section in bending costs G_f.
    #[test]
    fn s21_a_bent_section_costs_its_energy() {
        for stations in [3, 5, 7] {
            for share in [0.5, 0.8, 0.9] {
                let cost = bent(stations, share);
                println!("S21, {stations} stations, x = {share}: {cost:.3}");
                assert!((0.85..1.05).contains(&cost), "{stations}, {share}: {cost}");
            }
        }
    }

    /// Work over G_f of a section that is strained along that path until it is broken.
    fn torn(path: impl Fn(f64) -> SurfaceStrain) -> f64 {
        let law = glass(5);
        let (t, strength, length) = (3e-3, 30e6, 0.2e-3);
        let mut state = PointState::new(strength, [length * length, length * length, 0.0], t, 1.0);
        let mut tally = SectionTally::default();
        let mut s = 0.0;
        while !state.is_broken() {
            s += 1e-4 * strength / 70e9;
            law.step(&mut state, &path(s), &mut tally);
        }
        tally.dissipated * length / (8.0 * t)
    }

    /// A section costs G_f whatever mix of opening and sliding breaks it, if it is open throughout,
    /// and where it has started to break in bending and is pulled apart in its plane then.
    #[test]
    fn a_section_costs_its_energy_whatever_breaks_it() {
        let glass = 30e6 / 70e9;
        for slide in [0.0, 0.5, 1.0, 2.0] {
            // It slides once it has opened, for at onset it does neither in the crack's frame.
            let path = |s: f64| {
                let after = slide * (s - 1.2 * glass).max(0.0);
                SurfaceStrain { membrane: [s, 0.0, after], bending: [0.0; 3] }
            };
            let cost = torn(path);
            assert!((cost - 1.0).abs() < 0.02, "{slide}: {cost}");
        }
        let turn = |s: f64| {
            let (bent, pulled) = (s.min(1.5 * glass), (s - 1.5 * glass).max(0.0));
            let bending = [bent / 1.5e-3, 0.0, 0.0];
            SurfaceStrain { membrane: [pulled, 0.0, 0.0], bending }
        };
        let cost = torn(turn);
        assert!((cost - 1.0).abs() < 0.1, "bent, then pulled: {cost}");
    }

    /// At c = 0 the cracked law is plane stress.
    #[test]
    fn a_crack_without_damage_changes_nothing() {
        let law = glass(5);
        let mut state = PointState::new(30e6, [1e-6, 1e-6, 0.0], 3e-3, 1.0);
        let strain = SurfaceStrain { membrane: [3e-5, -4e-5, 1e-5], bending: [0.1, 0.2, -0.3] };
        let whole = law.borne(&state, &strain);
        state.cut(&law, [0.6, 0.8]);
        state.damage = 0.0;
        let cracked = law.borne(&state, &strain);
        for k in 0..3 {
            assert!((whole.force[k] - cracked.force[k]).abs() < 1e-9 * whole.force[0].abs());
            assert!((whole.moment[k] - cracked.moment[k]).abs() < 1e-9 * whole.moment[0].abs());
        }
    }
}
