//! What is worked out once for a sheet: its points, bonds and fits, and how long a step is.

use crate::bending::{BendingStencils, FASTEST};
use crate::bonds::MembraneBonds;
use crate::diffusion::DiffusionBonds;
use crate::grips::GrippedPoints;
use crate::kernel::order::lane_order;
use crate::kernel::rows::SheetRows;
use crate::law::{LeftShares, StretchLimits};
use crate::outline::SheetOutline;
use crate::points::{SheetPoints, relaxed};
use crate::scatter::factors;
use crate::surface::SheetTriangulation;
use crate::table::BondTable;
use cullet_continuum::WorkingPace;
use cullet_continuum::bytes::held;
use cullet_geometry::math::scramble;
use cullet_model::{
    ContinuumBody, ContinuumSetup, MembraneLaw, MembraneMaterial, MembraneSheet, Refusal,
    SheetDiffusion,
};
use std::sync::Arc;

/// Step over the longest stable one while bonds break. At 0.8 a bond is seen beyond s_c only a step
/// late and a crack spends 8 % more; at 0.4 it spends 4 % more, at 0.3 nothing.
const STEP: f64 = 0.4;
/// Most steps in one step of the world.
const MOST_STEPS: f64 = 1e6;
/// Most steps of what spreads in one step of the world.
const MOST_CYCLES: f64 = 2e4;
/// Radius of a point in contact, over the spacing, where the sheet is thinner: twice that.
const CONTACT: f64 = 0.3;

/// A sheet made discrete.
#[derive(Clone, Debug)]
pub struct PreparedMembrane {
    /// What it was made from.
    pub setup: ContinuumSetup,
    /// Its points.
    pub points: SheetPoints,
    /// Its bonds.
    pub bonds: MembraneBonds,
    /// s_c before anything changes it \[1\].
    pub critical: f64,
    /// s₀ or s_y likewise, before a cap \[1\].
    pub strength: f64,
    /// Λ \[N/m\]; zero where bonds alone bear.
    pub dilatation: f64,
    /// B, floor included \[J\].
    pub bending: f64,
    /// B over that of the material \[1\].
    pub bending_ratio: f64,
    /// Longest stable step \[s\].
    pub stable: f64,
    /// Steps in one step of the world.
    pub substeps: u32,
    pub(crate) pace: WorkingPace,
    pub(crate) stencils: BendingStencils,
    pub(crate) rows: Arc<SheetRows>,
    /// What each quantity spreads along.
    pub(crate) diffusion: Vec<DiffusionBonds>,
    pub(crate) grips: Vec<GrippedPoints>,
    pub(crate) table: BondTable,
    pub(crate) triangles: SheetTriangulation,
    /// The bond along each of its pairs, where there is one.
    pub(crate) pairs: Vec<Option<usize>>,
    /// Names this sheet in a state's bytes.
    pub(crate) fingerprint: u64,
}

impl PreparedMembrane {
    /// Memory that it takes, about \[bytes\].
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let points = held(&self.points.places) + held(&self.points.areas);
        let bonds = self.bonds.bytes() + self.stencils.bytes() + self.rows.bytes();
        let grips = self.grips.iter().map(GrippedPoints::bytes).sum::<u64>();
        let spread = self.diffusion.iter().map(DiffusionBonds::bytes).sum::<u64>();
        let drawn = self.triangles.bytes() + held(&self.pairs);
        points + bonds + self.table.bytes() + grips + spread + drawn
    }

    /// # Errors
    ///
    /// The bound that the sheet breaks.
    pub fn new(setup: &ContinuumSetup) -> Result<Self, Refusal> {
        let ContinuumBody::Membrane(sheet) = &setup.body else {
            let (what, kind) = ("this", "body");
            return Err(Refusal::Unknown { solver: crate::family::NAME, what, kind });
        };
        check(sheet, setup)?;
        let material = &sheet.material;
        let outline = SheetOutline::new(&sheet.outline)?;
        let reach = sheet.horizon * sheet.spacing;
        let points = relaxed(&outline, sheet.spacing, setup.seed)?;
        let points = points.in_order(&lane_order(&points.places, sheet.spacing, reach));
        let mut bonds = MembraneBonds::new(&points, &outline, sheet.spacing, sheet.horizon)?;
        let pace = WorkingPace::new(material.young, material.density, sheet.pace)?;
        let (modulus, dilatation) = moduli(material, pace.young, sheet.thickness);
        bonds.fit(&points.areas, modulus);
        let work = material.fracture_energy * sheet.thickness;
        let critical = bonds.critical_stretch(&points.areas, work);
        pace.admits(material.law, critical)?;
        let quantities = sheet.diffusion.all.iter();
        let diffusion = quantities.map(|what| DiffusionBonds::new(&points, &bonds, sheet, what));
        let diffusion = diffusion.collect::<Result<Vec<_>, Refusal>>()?;
        bonds.cut_along(&sheet.notches, &points.places);
        let mut stencils = BendingStencils::new(&bonds, sheet.spacing, sheet.horizon);
        for i in 0..points.places.len() {
            stencils.fit(i, &points.places, |b| !bonds.cut[b]);
        }
        let plate = |young: f64, thickness: f64| {
            young * sheet.thickness * thickness * thickness
                / (12.0 * (1.0 - material.poisson * material.poisson))
        };
        let own = plate(material.young, sheet.thickness);
        let bending = own.max(plate(pace.young, material.bending_floor * sheet.spacing));
        let grips = GrippedPoints::of_all(&sheet.grips, &points.places, reach)?;
        let triangles = SheetTriangulation::new(&points.places, &sheet.outline, sheet.spacing)?;
        let bond = |&[i, j]: &[u32; 2]| {
            let own = bonds.of(i as usize);
            let slot = bonds.ends[own.clone()].binary_search(&j).ok()?;
            Some(own.start + slot)
        };
        let pairs = triangles.pairs().iter().map(bond).collect();
        let strength = material.strength / material.young * pace.stretches;
        let scatter = factors(&points.places, sheet.spacing, material.scatter, setup.seed);
        let rows = Arc::new(SheetRows::new(&bonds, &stencils));
        let table = BondTable::new(&bonds, scatter, critical, strength, material.law);
        let mut prepared = Self {
            setup: setup.clone(),
            critical,
            strength,
            dilatation,
            bending,
            bending_ratio: bending / own,
            stable: 0.0,
            substeps: 0,
            pace,
            stencils,
            rows,
            diffusion,
            grips,
            table,
            triangles,
            pairs,
            fingerprint: 0,
            points,
            bonds,
        };
        prepared.choose_steps()?;
        prepared.fingerprint = prepared.name();
        Ok(prepared)
    }

    /// The sheet.
    #[must_use]
    pub fn sheet(&self) -> &MembraneSheet {
        let ContinuumBody::Membrane(sheet) = &self.setup.body else {
            unreachable!("it was looked at before points were made")
        };
        sheet
    }

    /// Length of a step \[s\].
    #[must_use]
    pub fn step(&self) -> f64 {
        self.setup.world_step / f64::from(self.substeps)
    }

    /// Edges of the surface that no bond holds together though no notch cuts them (F87m).
    pub(crate) fn edges_without_bonds(&self) -> usize {
        self.pairs.iter().filter(|pair| pair.is_none()).count()
    }

    /// Limits of an average bond.
    #[must_use]
    pub fn limits(&self) -> StretchLimits {
        let law = self.sheet().material.law;
        StretchLimits::new(law, self.strength, self.critical, LeftShares::WHOLE)
    }

    /// Distance below which the middle plane touches a rigid body \[m\].
    pub(crate) fn contact(&self) -> f64 {
        0.5 * self.sheet().thickness.max(CONTACT * self.sheet().spacing)
    }

    /// Mass and inertia of the dry sheet at a point \[kg\].
    pub(crate) fn dry(&self, i: usize) -> [f64; 2] {
        let sheet = self.sheet();
        let mass = sheet.material.density * sheet.thickness * self.points.areas[i];
        [mass, mass * self.pace.inertia]
    }

    /// The longest stable step is 2/ω, with ω² at most 2Σk/(mξ²) of any point and what bending
    /// adds. The dilatation stiffens waves of compression alone.
    fn choose_steps(&mut self) -> Result<(), Refusal> {
        let sheet = self.sheet();
        let material = &sheet.material;
        let most = |what: &SheetDiffusion| what.stiffness.iter().map(|r| r.1).fold(1.0, f64::max);
        let stiffest: f64 = sheet.diffusion.all.iter().map(most).product();
        let stiffer = match self.dilatation != 0.0 {
            true => (2.0 / (3.0 * (1.0 - material.poisson))).max(1.0),
            false => 1.0,
        };
        let rate = |i: usize| {
            let of = |b: usize| {
                let xi = self.bonds.lengths[b];
                self.bonds.stiffness[b] / (xi * xi)
            };
            2.0 * self.bonds.of(i).map(of).sum::<f64>() / self.dry(i)[1]
        };
        let fastest = (0..self.points.areas.len()).map(rate).fold(0.0, f64::max) * stiffer;
        let by_area = material.density * self.pace.inertia * sheet.thickness;
        let squared = sheet.spacing * sheet.spacing;
        let bending = FASTEST * self.bending / (by_area * squared * squared);
        let base = sheet.foundation.unwrap_or(0.0) / by_area;
        self.stable = 2.0 / ((fastest + bending) * stiffest + base).sqrt();
        let steps = (self.setup.world_step / (STEP * self.stable)).ceil();
        if steps.is_nan() || steps > MOST_STEPS {
            let what = "the steps of a sheet in one of the world (choose a slower pace)";
            return Err(Refusal::TooLarge { what, value: steps, limit: MOST_STEPS });
        }
        self.substeps = steps.max(1.0) as u32;
        let cycles = self.diffusion.iter().map(|it| self.setup.world_step / it.step);
        let cycles = cycles.fold(0.0, f64::max);
        if cycles > MOST_CYCLES {
            let what = "the steps of what spreads in a sheet in one of the world";
            return Err(Refusal::TooLarge { what, value: cycles, limit: MOST_CYCLES });
        }
        Ok(())
    }

    /// A number that other sheets do not have.
    fn name(&self) -> u64 {
        let places = self.points.places.iter().flatten();
        let all = places.chain(&self.bonds.stiffness).chain([&self.stable, &self.critical]);
        all.fold(1, |name, value| scramble(name ^ value.to_bits()))
    }
}

/// ½A⁻¹Σk that bonds should have and Λ \[N/m\]. Bonds alone have ν = 1/3; elsewhere they bear the
/// shear, 8μh, and the dilatation of points, Λ = (Eν/(1 − ν²) − μ)h, what is missing. That holds
/// for small strains.
fn moduli(material: &MembraneMaterial, young: f64, h: f64) -> (f64, f64) {
    let nu = material.poisson;
    if material.law == MembraneLaw::Rubber {
        return (3.0 * young * h, 0.0);
    }
    let shear = young / (2.0 * (1.0 + nu));
    let lambda = (young * nu / (1.0 - nu * nu) - shear) * h;
    match lambda.abs() > 1e-9 * young * h {
        true => (8.0 * shear * h, lambda),
        false => (3.0 * young * h, 0.0),
    }
}

/// That numbers are within their bounds.
fn check(sheet: &MembraneSheet, setup: &ContinuumSetup) -> Result<(), Refusal> {
    sheet.check()?;
    let (what, value, low, high) = ("step of the world [s]", setup.world_step, 1e-9, 1.0);
    if value.is_nan() || value < low || value > high {
        return Err(Refusal::OutOfRange { what, value, low, high });
    }
    let vectors = [setup.gravity, sheet.velocity, sheet.air.wind];
    let finite = vectors.iter().flatten().all(|c| c.is_finite()) && sheet.air.pressure.is_finite();
    let notches = sheet.notches.iter().flatten().flatten().all(|c| c.is_finite());
    if !finite || !notches {
        let lack = "its motion, its notches and the air need finite numbers".to_owned();
        return Err(Refusal::Unfit { solver: crate::family::NAME, lack });
    }
    Ok(())
}
