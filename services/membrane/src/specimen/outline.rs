//! The sheet that a solid is: its middle plane and the outline in it.

use crate::outline::turn;
use cullet_geometry::plate::Plate;
use cullet_geometry::{Pose, Quat, TriMesh, Vec3};
use cullet_model::{Refusal, SheetPlace};
use std::collections::BTreeMap;

/// How far a sheet may be turned against the specimen's axes: 1 − |cos|.
const STRAIGHT: f64 = 1e-9;
/// How far a face may be out of its plane, over the thickness.
const FLAT: f64 = 1e-3;

/// A sheet along the axes of its specimen.
#[derive(Clone, Debug)]
pub(super) struct AlignedSheet {
    /// Counter-clockwise, in its plane \[m\].
    pub(super) outline: Vec<SheetPlace>,
    /// \[m\].
    pub(super) thickness: f64,
    /// From its plane to the specimen.
    pub(super) pose: Pose,
    /// The axes of the specimen that its x, its y and its normal lie along.
    pub(super) axes: [usize; 3],
}

pub(super) fn unfit(lack: String) -> Refusal {
    Refusal::Unfit { solver: crate::family::NAME, lack }
}

impl AlignedSheet {
    /// # Errors
    ///
    /// What the body lacks that is no flat plate along the axes, or has holes.
    pub(super) fn new(mesh: &TriMesh) -> Result<Self, Refusal> {
        let plate = Plate::of_mesh(mesh).map_err(|why| unfit(why.to_string()))?;
        let normal = plate.pose.rotation * Vec3::z();
        let across = normal.iamax();
        let turned = (1.0 - normal[across].abs()).max(0.0);
        if turned > STRAIGHT {
            let what = "1 − |cos| between the sheet's normal and an axis";
            return Err(Refusal::OutOfRange { what, value: turned, low: 0.0, high: STRAIGHT });
        }
        let axes = [(across + 1) % 3, (across + 2) % 3, across];
        let (low, high) = mesh.bounds().unwrap_or_default();
        let up = Vec3::ith(across, 1.0);
        let middle = up * (0.5 * (low[across] + high[across]));
        let rotation = Quat::from_basis_unchecked(&axes.map(|axis| Vec3::ith(axis, 1.0)));
        let flat = |v: u32| {
            let x = mesh.vertices[v as usize];
            [x[axes[0]], x[axes[1]]]
        };
        let at_top =
            |v: u32| high[across] - mesh.vertices[v as usize][across] <= FLAT * plate.thickness;
        let top = mesh.triangles.iter().filter(|corners| corners.iter().all(|&v| at_top(v)));
        let outline = rim(top.copied())?.into_iter().map(flat).collect();
        Ok(Self {
            outline: without_straights(outline),
            thickness: plate.thickness,
            pose: Pose::from_parts(middle.into(), rotation),
            axes,
        })
    }

    /// A place of its plane in the specimen, at a height over it \[t\].
    pub(super) fn place(&self, [x, y]: SheetPlace, height: f64) -> Vec3 {
        (self.pose * nalgebra::Point3::new(x, y, height * self.thickness)).coords
    }
}

/// The vertices around triangles, in the order of these.
fn rim(triangles: impl Iterator<Item = [u32; 3]>) -> Result<Vec<u32>, Refusal> {
    let mut edges: BTreeMap<[u32; 2], i32> = BTreeMap::new();
    for [a, b, c] in triangles {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            if edges.remove(&[to, from]).is_none() {
                edges.insert([from, to], 1);
            }
        }
    }
    let next: BTreeMap<u32, u32> = edges.keys().map(|&[from, to]| (from, to)).collect();
    let mut loops = vec![next.keys().next().copied().unwrap_or(0)];
    while let Some(&to) = loops.last().and_then(|last| next.get(last)) {
        if to == loops[0] {
            break;
        }
        loops.push(to);
        if loops.len() > next.len() {
            break;
        }
    }
    match loops.len() == edges.len() {
        true => Ok(loops),
        false => Err(unfit(format!(
            "its face has {} edges, {} of them in one outline: a sheet has no holes",
            edges.len(),
            loops.len()
        ))),
    }
}

/// Corners alone: meshes have vertices along their edges, too.
fn without_straights(mut corners: Vec<SheetPlace>) -> Vec<SheetPlace> {
    let mut k = 0;
    while k < corners.len() && corners.len() > 3 {
        let n = corners.len();
        match turn(corners[(k + n - 1) % n], corners[k], corners[(k + 1) % n]) == 0.0 {
            true => drop(corners.remove(k)),
            false => k += 1,
        }
    }
    corners
}
