//! From a sheet as it is written to one that a window can be opened for.

use super::context::ResolveContext;
use super::format::{
    Coupling, Diffusion, Diffusions, Grip, SheetBody, SheetInflow, SheetLaw, SheetPatch,
};
use super::material::SceneMaterial;
use super::moving::{DAMPING, LONGEST, SceneMovingBody, WINDOW, air};
use cullet_document::error::{nearest, suggest};
use cullet_document::tree::{Path, join};
use cullet_geometry::{Pose, Vec3};
use cullet_model::membrane::FIRST_QUANTITY;
use cullet_model::{
    ContinuumBody, MembraneLaw, MembraneMaterial, MembraneSheet, SheetDiffusion, SheetGrip,
    SheetPlace, SheetQuantities, SheetRegion, SheetSource, SheetSourceKind,
};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Reach of bonds over the distance of points \[1\]: moduli are within 0.5 % there.
const HORIZON: f64 = 3.015;
/// Thickness by which a sheet bends at least, over the distance of its points \[1\].
const BENDING_FLOOR: f64 = 0.3;
/// Share of the longer side of its box that the distance of points is \[1\].
const SPACING: f64 = 0.02;
/// θ that no sheet reaches.
const UNBOUNDED: f64 = 1e300;
/// Around every sheet.
const WHOLE_SHEET: SheetRegion = SheetRegion::Box { low: [-UNBOUNDED; 2], high: [UNBOUNDED; 2] };
/// Longest name of a quantity \[bytes\].
const MAX_QUANTITY_NAME: usize = 40;

impl ResolveContext<'_> {
    /// Makes a sheet ready; errors are noted, and `None` means that there were some.
    pub(super) fn sheet(&mut self, written: &SheetBody, path: &Path) -> Option<SceneMovingBody> {
        let before = self.errors.len();
        for (key, there) in [
            ("name", written.name.is_some()),
            ("thickness", written.thickness.is_some()),
            ("material", written.material.is_some()),
        ] {
            if !there && self.lacks(path, &[key]) {
                self.wrong(path, format!("`{key}` is missing"));
            }
        }
        let outline = self.outline(written, path);
        let material = self.sheet_material(written, path);
        let rotation = self.rotation(&written.rotation, &join(path, "rotation"));
        let pace = self.pace(written.pace, path);
        let mut grips = Vec::new();
        for (index, grip) in written.grip.iter().enumerate() {
            let path = join(&join(path, "grip"), index);
            grips.extend(self.grip(grip, &path));
        }
        let diffusion = self.quantities(written, path);
        if let Some(notch) = written.notches.iter().position(|notch| notch.len() < 2) {
            self.wrong(&join(&join(path, "notches"), notch), "needs two corners or more");
        }
        let (Some(outline), Some(material)) = (outline, material) else { return None };
        let longer = box_of(&outline).iter().fold(0.0_f64, |a, b| a.max(*b));
        let sheet = MembraneSheet {
            outline,
            notches: written.notches.clone(),
            thickness: written.thickness?,
            spacing: written.spacing.unwrap_or(SPACING * longer) * self.fidelity.coarser_surface(),
            horizon: HORIZON,
            material: membrane(&material, written),
            pose: Pose::from_parts(Vec3::from(written.position).into(), rotation),
            velocity: Vec3::from(written.velocity),
            grips,
            air: air(Some(written.air)),
            diffusion,
            foundation: written.foundation,
            pace,
        };
        if self.errors.len() == before {
            self.sheet_faults(&sheet, written, path);
        }
        (self.errors.len() == before).then(|| SceneMovingBody {
            name: written.name.clone().unwrap_or_default(),
            material: Arc::clone(&material),
            body: ContinuumBody::Membrane(sheet),
            window: written.window.unwrap_or(WINDOW),
            two_way: written.coupling == Coupling::TwoWay,
            retire: written.retire,
        })
    }

    /// Notes what cannot hold of a sheet, each at its key.
    fn sheet_faults(&mut self, sheet: &MembraneSheet, written: &SheetBody, path: &Path) {
        let single = matches!(written.diffusion, Some(Diffusions::One(_)));
        for fault in sheet.faults() {
            let step = |at: Path, step: &str| match step.parse::<usize>() {
                Ok(number) => join(&at, number),
                Err(_) => join(&at, step),
            };
            let key = match fault.key.strip_prefix("diffusion.0.").filter(|_| single) {
                Some(own) => format!("diffusion.{own}"),
                None => fault.key,
            };
            let at = key.split('.').fold(path.clone(), step);
            self.wrong(&at, fault.refusal.to_string());
        }
    }

    fn outline(&mut self, written: &SheetBody, path: &Path) -> Option<Vec<SheetPlace>> {
        let corners = match (written.size, &written.outline) {
            (Some([width, height]), None) => {
                if width <= 0.0 || height <= 0.0 {
                    self.wrong(&join(path, "size"), "both lengths must be above 0 m");
                    return None;
                }
                let (x, y) = (0.5 * width, 0.5 * height);
                return Some(vec![[-x, -y], [x, -y], [x, y], [-x, y]]);
            }
            (None, Some(corners)) => corners.clone(),
            _ => {
                if self.lacks(path, &["size", "outline"]) || written.size.is_some() {
                    self.wrong(path, "takes `size` or `outline`, one of them");
                }
                return None;
            }
        };
        let path = join(path, "outline");
        let area = twice_area(&corners);
        if corners.len() < 3 || area == 0.0 {
            self.wrong(&path, "has no area: give three corners or more that are not on a line");
            return None;
        }
        if crosses(&corners) {
            self.wrong(&path, "crosses itself");
            return None;
        }
        Some(if area > 0.0 { corners } else { corners.into_iter().rev().collect() })
    }

    fn sheet_material(&mut self, written: &SheetBody, path: &Path) -> Option<Arc<SceneMaterial>> {
        let name = written.material.as_ref()?;
        let material = self.materials.get(name).map(Arc::clone);
        if material.is_none() && !self.spoiled_materials.contains(name) {
            let known: Vec<&str> = self.materials.keys().map(String::as_str).collect();
            let help = self.advice(|| suggest(name, &known));
            let message = format!("there is no material \"{name}\"");
            self.wrong_with(&join(path, "material"), message, help);
        }
        if let (Some(material), Some(SheetLaw::Foil)) = (&material, written.law)
            && material.plasticity.is_none()
        {
            let message = format!("{} does not yield: `foil` needs `plasticity`", material.name);
            self.wrong(&join(path, "law"), message);
        }
        material
    }

    fn patch(&mut self, patch: &SheetPatch, path: &Path) -> Option<SheetRegion> {
        let path = join(path, "patch");
        match (patch.low, patch.high, patch.centre, patch.radius) {
            (Some(low), Some(high), None, None) if low[0] <= high[0] && low[1] <= high[1] => {
                Some(SheetRegion::Box { low, high })
            }
            (Some(_), Some(_), None, None) => {
                self.wrong(&path, "`low` must be at most `high`");
                None
            }
            (None, None, Some(centre), Some(radius)) => Some(SheetRegion::Disc { centre, radius }),
            _ => {
                self.wrong(&path, "takes `low` and `high`, or `centre` and `radius`");
                None
            }
        }
    }

    fn grip(&mut self, grip: &Grip, path: &Path) -> Option<SheetGrip> {
        let region = self.patch(&grip.patch, path);
        let rows = self.grip_rows(grip.velocity, &grip.path, path);
        Some(SheetGrip { region: region?, path: rows, until: grip.until })
    }

    /// The quantities of a sheet, with their names and the one that is shown.
    fn quantities(&mut self, written: &SheetBody, path: &Path) -> SheetQuantities {
        let each = written.diffusion.as_ref().map_or_else(Vec::new, Diffusions::each);
        let mut quantities = SheetQuantities::default();
        let mut chosen = None;
        for (number, (below, one)) in (0..).zip(&each) {
            let path: Path = path.iter().chain(below).cloned().collect();
            quantities.all.extend(self.diffusion(one, &path));
            let name = self.quantity_name(one, each.len(), &path);
            if quantities.names.contains(&name) {
                let message = format!("a second quantity is called \"{name}\"");
                self.wrong(&join(&path, "name"), message);
            }
            quantities.names.push(name);
            if one.show == Some(true) && chosen.replace(number).is_some() {
                self.wrong(&join(&path, "show"), "another quantity of the sheet is shown already");
            }
        }
        let first = each.iter().position(|(_, one)| one.show != Some(false)).unwrap_or(0);
        quantities.shown = chosen.unwrap_or(first as u32);
        if quantities.names == [FIRST_QUANTITY] {
            quantities.names.clear();
        }
        quantities
    }

    fn quantity_name(&mut self, written: &Diffusion, count: usize, path: &Path) -> String {
        match &written.name {
            Some(name) if name.trim().is_empty() || name.len() > MAX_QUANTITY_NAME => {
                let message = format!("a name has 1 to {MAX_QUANTITY_NAME} bytes");
                self.wrong(&join(path, "name"), message);
            }
            None if count > 1 && self.lacks(path, &["name"]) => {
                self.wrong(path, "`name` is missing: each of several quantities has its own");
            }
            _ => {}
        }
        written.name.clone().unwrap_or_else(|| FIRST_QUANTITY.to_owned())
    }

    fn diffusion(&mut self, written: &Diffusion, path: &Path) -> Option<SheetDiffusion> {
        let tables = [
            ("stiffness", &written.stiffness),
            ("toughness", &written.toughness),
            ("strength", &written.strength),
        ];
        for (key, rows) in tables {
            if rows.windows(2).any(|two| two[1][0] <= two[0][0]) {
                self.wrong(&join(path, key), "its rows must have rising values of the quantity");
            }
            if rows.iter().any(|row| !(1e-3..=100.0).contains(&row[1])) {
                self.wrong(&join(path, key), "a share must lie from 0.001 to 100");
            }
        }
        if written.diffusivity.iter().any(|d| !(1e-12..=1e3).contains(&(d * written.capacity))) {
            let message = "times `capacity` it must lie from 1e-12 to 1000 m²/s";
            self.wrong(&join(path, "diffusivity"), message);
        }
        let mut sources = Vec::new();
        for (index, source) in written.source.iter().enumerate() {
            let path = join(&join(path, "source"), index);
            sources.extend(self.inflow(source, &path));
        }
        let table = |rows: &Vec<[f64; 2]>| rows.iter().map(|&[at, share]| (at, share)).collect();
        Some(SheetDiffusion {
            capacity: written.capacity,
            conductivity: written.diffusivity.map(|d| d * written.capacity),
            expansion: written.expansion,
            start: written.start,
            saturation: written.saturation.unwrap_or(UNBOUNDED),
            stiffness: table(&written.stiffness),
            toughness: table(&written.toughness),
            strength: table(&written.strength),
            exposure: written.exposure,
            weight: written.weight,
            loss: written.loss * written.capacity,
            ambient: written.ambient,
            sources,
        })
    }

    /// Notes each rigid body that a sheet names and that is not there; why one that is written was
    /// not made is an error already.
    pub(super) fn report_absent(
        &mut self,
        absent: Vec<(Path, String)>,
        moving: &[SceneMovingBody],
    ) {
        let moving: BTreeSet<&str> = moving.iter().map(|body| body.name.as_str()).collect();
        for (path, name) in absent {
            let near = || nearest(&name, self.objects.keys().map(String::as_str));
            let help = self.advice(near).map(|near| format!("did you mean `{near}`?"));
            let message = match moving.contains(&name[..]) {
                true => format!("\"{name}\" is no rigid body: it deforms"),
                false => format!("there is no rigid body \"{name}\""),
            };
            self.wrong_with(&path, message, help);
        }
    }

    fn inflow(&mut self, source: &SheetInflow, path: &Path) -> Option<SheetSource> {
        let region = match (&source.patch, &source.body) {
            (Some(patch), _) => self.patch(patch, path),
            (None, Some(_)) => Some(WHOLE_SHEET),
            (None, None) => {
                if self.lacks(path, &["patch", "body"]) {
                    self.wrong(path, "`patch` is missing: give it, or a `body` that it comes from");
                }
                None
            }
        };
        let object = source.body.as_ref().map(|name| self.object(name, &join(path, "body")));
        let kind = match (source.value, source.flux, source.film, source.towards) {
            (Some(value), None, None, None) if object.is_none() => {
                Some(SheetSourceKind::Held(value))
            }
            (None, Some(flux), None, None) if object.is_none() => Some(SheetSourceKind::Flux(flux)),
            (None, None, Some(film), Some(towards)) => Some(match object {
                Some(object) => SheetSourceKind::Contact { object, towards, film },
                None => SheetSourceKind::Film(towards, film),
            }),
            _ if object.is_some() => {
                self.wrong(path, "takes `film` and `towards` beside `body`, no `value` or `flux`");
                None
            }
            _ => {
                self.wrong(path, "takes `value`, or `flux`, or `film` and `towards`");
                None
            }
        };
        let (from, until) = (source.from.unwrap_or(0.0), source.until.unwrap_or(LONGEST));
        if until <= from {
            self.wrong(&join(path, "until"), "must be after `from`");
        }
        Some(SheetSource { region: region?, from, until, kind: kind? })
    }
}

fn membrane(material: &SceneMaterial, written: &SheetBody) -> MembraneMaterial {
    let law = match written.law {
        Some(SheetLaw::Brittle) => MembraneLaw::Brittle,
        Some(SheetLaw::Foil) => MembraneLaw::Foil,
        Some(SheetLaw::Rubber) => MembraneLaw::Rubber,
        None if material.plasticity.is_some() => MembraneLaw::Foil,
        None => MembraneLaw::Brittle,
    };
    let yields = material.plasticity.filter(|_| law == MembraneLaw::Foil);
    MembraneMaterial {
        density: material.density,
        young: material.young,
        poisson: material.poisson,
        fracture_energy: material.fracture_energy,
        strength: yields.map_or(material.strength, |plasticity| plasticity.hardening.yield_stress),
        law,
        scatter: written.scatter,
        bending_floor: written.bending_floor.unwrap_or(BENDING_FLOOR),
        damping: written.damping.unwrap_or(DAMPING),
    }
}

fn box_of(corners: &[SheetPlace]) -> [f64; 2] {
    [0, 1].map(|axis| {
        let along = corners.iter().map(|corner| corner[axis]);
        let (low, high) = along.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
        high - low
    })
}

fn twice_area(corners: &[SheetPlace]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum()
}

/// Whether two sides of a polygon that are no neighbours meet.
fn crosses(corners: &[SheetPlace]) -> bool {
    let count = corners.len();
    let side = |k: usize| (corners[k], corners[(k + 1) % count]);
    let turn = |a: SheetPlace, b: SheetPlace, c: SheetPlace| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    // Sides whose boxes are apart do not meet, also where they lie on one line.
    let apart = |(a, b): (SheetPlace, SheetPlace), (c, d): (SheetPlace, SheetPlace)| {
        (0..2).any(|k| a[k].max(b[k]) < c[k].min(d[k]) || c[k].max(d[k]) < a[k].min(b[k]))
    };
    (0..count).any(|i| {
        (i + 2..count).filter(|&j| (j + 1) % count != i && !apart(side(i), side(j))).any(|j| {
            let ((a, b), (c, d)) = (side(i), side(j));
            turn(a, b, c) * turn(a, b, d) <= 0.0 && turn(c, d, a) * turn(c, d, b) <= 0.0
        })
    })
}
