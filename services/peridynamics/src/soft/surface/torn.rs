//! The surface of a body with open faces.

use super::clip::{HalfPlane, area, clipped, square};
use super::{
    AROUND, BondHold, CarriedSurface, CarriedVertex, HeldBonds, SurfaceTemplate, grouped, shares,
};
use cullet_geometry::Vec3;
use std::collections::{BTreeMap, BTreeSet};

/// Places as near as this, in spacings, are one.
const SAME: f64 = 1e-4;
/// Faces are looked for between points up to this distance, and cut by points up to that, in
/// spacings.
const NEIGHBOURS: f64 = 2.4;
const CUTTERS: f64 = 2.8;
/// Half a side of the square that a face is cut from, in spacings.
const SQUARE: f64 = 1.6;
/// Faces of points deeper than this, in spacings, do not reach the surface.
const DEEP: f64 = 1.8;
/// Rounds in which torn faces are smoothed, and share of the way that a corner goes in one.
const ROUNDS: usize = 4;
const FOLLOWED: f64 = 0.7;
/// Polygons with less than this area, in squares of the spacing, are none.
const TINY: f64 = 1e-6;

/// A surface in the making, with which bonds hold.
pub(in super::super) struct TornSolid<'a> {
    template: &'a SurfaceTemplate,
    held: &'a HeldBonds,
    /// Whether all short bonds of a point hold.
    sound: Vec<bool>,
    /// The points around each place, by rising distance, with the names of their groups.
    groups: BTreeMap<[i64; 3], Vec<(u32, u32)>>,
    /// Vertices by place and group.
    known: BTreeMap<([i64; 3], u32), u32>,
    vertices: Vec<CarriedVertex>,
    triangles: Vec<[u32; 3]>,
    /// Parts of the surface that are not triangles yet, with the points whose cells they are of.
    polygons: Vec<(Option<u32>, Vec<Vec3>)>,
    /// Corners of torn faces, and where they are drawn.
    inner: BTreeMap<[i64; 3], Vec3>,
}

impl<'a> TornSolid<'a> {
    /// The surface where these bonds hold.
    pub(in super::super) fn surface(
        template: &'a SurfaceTemplate,
        held: &'a HeldBonds,
    ) -> CarriedSurface {
        let count = template.rest.len() as u32;
        let sound = (0..count).map(|p| template.is_sound(held, p)).collect();
        let mut torn = Self {
            template,
            held,
            sound,
            groups: BTreeMap::new(),
            known: BTreeMap::new(),
            vertices: Vec::new(),
            triangles: Vec::new(),
            polygons: Vec::new(),
            inner: BTreeMap::new(),
        };
        torn.outer();
        for p in (0..count).filter(|&p| !torn.sound[p as usize]).collect::<Vec<_>>() {
            torn.faces(p);
            torn.lips(p);
        }
        torn.triangulate();
        CarriedSurface::new(torn.triangles, torn.vertices)
    }

    /// The body's own surface: as it is where all around is held together, else by cells.
    fn outer(&mut self) {
        let template = self.template;
        let whole = |near: &Vec<u32>| {
            near.iter().all(|&p| self.sound[p as usize]) || {
                let names = grouped(near, self.held);
                names.iter().all(|name| *name == names[0])
            }
        };
        let whole: Vec<bool> = template.near.iter().map(whole).collect();
        let triangles = &template.mesh.triangles;
        let torn = |corners: &[u32; 3]| corners.iter().any(|&v| !whole[v as usize]);
        // Whether a vertex is one of a triangle that is taken apart.
        let mut beside = vec![false; whole.len()];
        for corners in triangles.iter().filter(|corners| torn(corners)) {
            corners.iter().for_each(|&v| beside[v as usize] = true);
        }
        for corners in triangles {
            if torn(corners) {
                self.by_cells(*corners);
                continue;
            }
            let places = corners.map(|v| template.mesh.vertices[v as usize]);
            if corners.iter().filter(|&&v| beside[v as usize]).count() > 1 {
                self.polygons.push((None, places.to_vec()));
                continue;
            }
            let ids = [0, 1, 2].map(|k| {
                let near = &template.near[corners[k] as usize];
                let least = near.iter().copied().min().unwrap_or(0);
                self.put(places[k], least, near)
            });
            self.triangles.push(ids);
        }
    }

    /// A triangle of the surface, taken apart by the cells of the points around it.
    fn by_cells(&mut self, corners: [u32; 3]) {
        let template = self.template;
        let places = corners.map(|v| template.mesh.vertices[v as usize]);
        let mut all: Vec<u32> =
            corners.iter().flat_map(|&v| &template.near[v as usize]).copied().collect();
        all.sort_unstable();
        all.dedup();
        for &p in &all {
            let mut part = places.to_vec();
            for &q in all.iter().filter(|&&q| q != p) {
                part = clipped(&part, &self.between(p, q));
                if part.is_empty() {
                    break;
                }
            }
            self.draw(p, part);
        }
    }

    /// The cut that parts two points.
    fn cut_between(&self, p: u32, q: u32) -> Option<usize> {
        let [x, y] = [p, q].map(|k| &self.template.rest[k as usize]);
        self.template.cuts.iter().position(|cut| cut.parts(x, y))
    }

    /// The plane of a cut through the body, so that a point is on its lower side.
    fn plane(&self, cut: usize, p: u32) -> HalfPlane {
        let corners = &self.template.cuts[cut].corners;
        let normal = area(corners).try_normalize(0.0).unwrap_or_default();
        let offset = corners.first().map_or(0.0, |x| normal.dot(x));
        let below = normal.dot(&self.template.rest[p as usize]) < offset;
        if below {
            HalfPlane { normal, offset }
        } else {
            HalfPlane { normal: -normal, offset: -offset }
        }
    }

    /// What is nearer to one point than to another, or on its side of the cut between them.
    fn between(&self, p: u32, q: u32) -> HalfPlane {
        if let Some(cut) = self.cut_between(p, q) {
            return self.plane(cut, p);
        }
        let [x, y] = [p, q].map(|k| self.template.rest[k as usize]);
        let normal = (y - x).normalize();
        HalfPlane { normal, offset: 0.5 * normal.dot(&(x + y)) }
    }

    /// Points up to `reach` spacings from one.
    fn around(&self, p: u32, reach: f64) -> Vec<u32> {
        let template = self.template;
        let (x, reach) = (template.rest[p as usize], reach * template.spacing);
        let mut found = Vec::new();
        template.cells.around(&x, 2, |q| {
            if q != p && (template.rest[q as usize] - x).norm() <= reach {
                found.push(q);
            }
        });
        found
    }

    /// Faces between the cells of a point and of later ones that are not held together there.
    fn faces(&mut self, p: u32) {
        let template = self.template;
        let cutters = self.around(p, CUTTERS);
        for q in self.around(p, NEIGHBOURS) {
            let holds = || self.held.hold(p, q) == BondHold::Full;
            // Of two points with broken bonds the lesser draws the face.
            let drawn = q < p && !self.sound[q as usize];
            if drawn || holds() || self.cut_between(p, q).is_some() {
                continue;
            }
            let half = self.between(p, q);
            let middle = 0.5 * (template.rest[p as usize] + template.rest[q as usize]);
            let mut face = square(middle, half.normal, SQUARE * template.spacing);
            for &r in cutters.iter().filter(|&&r| r != q) {
                face = clipped(&face, &self.between(p, r));
                if face.is_empty() {
                    break;
                }
            }
            let face = self.in_body(face, [p, q]);
            let apart = |torn: &mut Self, x: &Vec3| torn.name(x, p) != torn.name(x, q);
            if face.iter().any(|x| apart(self, x)) {
                let back: Vec<Vec3> = face.iter().rev().copied().collect();
                for x in &face {
                    let key = self.key(x);
                    self.inner.entry(key).or_insert(*x);
                }
                self.draw(p, face);
                self.draw(q, back);
            }
        }
    }

    /// The lips of cuts beside a point, in their planes.
    fn lips(&mut self, p: u32) {
        let template = self.template;
        if template.cuts.is_empty() {
            return;
        }
        let cutters = self.around(p, CUTTERS);
        for cut in 0..template.cuts.len() {
            let x = template.rest[p as usize];
            let parted = |q: u32| template.cuts[cut].parts(&x, &template.rest[q as usize]);
            let reach = NEIGHBOURS * template.spacing;
            let near = |q: u32| (template.rest[q as usize] - x).norm() <= reach;
            if !cutters.iter().any(|&q| near(q) && parted(q)) {
                continue;
            }
            let half = self.plane(cut, p);
            let foot = x + half.normal * (half.offset - half.normal.dot(&x));
            let mut lip = square(foot, half.normal, SQUARE * template.spacing);
            for &r in &cutters {
                if !parted(r) {
                    lip = clipped(&lip, &self.between(p, r));
                }
                if lip.is_empty() {
                    break;
                }
            }
            let lip = self.in_body(lip, [p, p]);
            self.draw(p, lip);
        }
    }

    fn in_body(&self, face: Vec<Vec3>, points: [u32; 2]) -> Vec<Vec3> {
        let deep = DEEP * self.template.spacing;
        let near = points.iter().any(|&p| self.template.depths[p as usize] < deep);
        if near && !face.is_empty() { self.template.body.clip(face) } else { face }
    }

    /// Adds a polygon of a point's cell.
    fn draw(&mut self, p: u32, polygon: Vec<Vec3>) {
        let least = TINY * self.template.spacing * self.template.spacing;
        if area(&polygon).norm() >= least {
            self.polygons.push((Some(p), polygon));
        }
    }

    /// Makes triangles of all polygons. Where corners of others lie on the sides of one, it gets
    /// them too, so that neighbours meet without gaps.
    fn triangulate(&mut self) {
        let polygons = std::mem::take(&mut self.polygons);
        let mut corners = CornerCells::new(self.template.spacing);
        for x in polygons.iter().flat_map(|polygon| &polygon.1) {
            corners.put(self.key(x), *x);
        }
        self.smooth(&polygons);
        for (owner, polygon) in polygons {
            let mut all = Vec::new();
            for (k, x) in polygon.iter().enumerate() {
                all.push(*x);
                corners.between(x, &polygon[(k + 1) % polygon.len()], &mut all);
            }
            let more = all.len() > polygon.len();
            let mut ids: Vec<u32> = all.iter().map(|x| self.corner(owner, x)).collect();
            ids.dedup();
            if ids.len() > 1 && ids.first() == ids.last() {
                ids.pop();
            }
            if ids.len() < 3 {
                continue;
            }
            if more {
                // A fan from a corner would have triangles without area.
                let middle = polygon.iter().sum::<Vec3>() / polygon.len() as f64;
                if let Some(drawn) = self.drawn_middle(&polygon) {
                    let key = self.key(&middle);
                    self.inner.insert(key, drawn);
                }
                let middle = self.corner(owner, &middle);
                for (k, id) in ids.iter().enumerate() {
                    self.triangles.push([middle, *id, ids[(k + 1) % ids.len()]]);
                }
            } else {
                let fan = (2..ids.len()).map(|k| [ids[0], ids[k - 1], ids[k]]);
                self.triangles.extend(fan);
            }
        }
    }

    /// The middle of a polygon as it is drawn, if all its corners are of torn faces.
    fn drawn_middle(&self, polygon: &[Vec3]) -> Option<Vec3> {
        let drawn: Option<Vec<&Vec3>> =
            polygon.iter().map(|x| self.inner.get(&self.key(x))).collect();
        let drawn = drawn?;
        Some(drawn.iter().copied().sum::<Vec3>() / drawn.len() as f64)
    }

    /// Draws torn faces smoother than the cells of points are, alike on both sides: each corner
    /// goes to the mean of those next to it, but for those on the body's surface and on cuts.
    fn smooth(&mut self, polygons: &[(Option<u32>, Vec<Vec3>)]) {
        let mut uses: BTreeMap<[i64; 3], Vec<[i64; 3]>> = BTreeMap::new();
        let mut fixed = BTreeSet::new();
        for (_, polygon) in polygons {
            let keys: Vec<[i64; 3]> = polygon.iter().map(|x| self.key(x)).collect();
            if keys.iter().any(|key| !self.inner.contains_key(key)) {
                // One of the surface or of a cut.
                fixed.extend(keys);
                continue;
            }
            for (k, key) in keys.iter().enumerate() {
                let next = keys[(k + 1) % keys.len()];
                uses.entry(*key).or_default().push(next);
                uses.entry(next).or_default().push(*key);
            }
        }
        for _ in 0..ROUNDS {
            let before = self.inner.clone();
            for (key, x) in &mut self.inner {
                let Some(beside) = uses.get(key).filter(|_| !fixed.contains(key)) else { continue };
                let mean = beside.iter().filter_map(|key| before.get(key)).sum::<Vec3>();
                *x += (mean / beside.len() as f64 - *x) * FOLLOWED;
            }
        }
    }

    /// The vertex at a corner of a polygon; without an owner it is of the point next to it.
    fn corner(&mut self, owner: Option<u32>, x: &Vec3) -> u32 {
        let p = owner.or_else(|| self.group(x).first().map(|it| it.0));
        self.vertex(x, p.unwrap_or(0))
    }

    fn key(&self, x: &Vec3) -> [i64; 3] {
        // Shifted, so that round numbers lie within a cell.
        let cell = SAME * self.template.spacing;
        [0, 1, 2].map(|axis| (x[axis] / cell + 0.37).floor() as i64)
    }

    /// The points around a place, by rising distance, with the names of their groups.
    fn group(&mut self, x: &Vec3) -> &[(u32, u32)] {
        let (key, template, held) = (self.key(x), self.template, self.held);
        self.groups.entry(key).or_insert_with(|| {
            let near = template.cells.nearest(&template.rest, x, AROUND);
            let names = grouped(&near, held);
            near.into_iter().zip(names).collect()
        })
    }

    /// Name of the group of points around a place to which one belongs.
    fn name(&mut self, x: &Vec3, p: u32) -> u32 {
        let held = self.held;
        let found = self.group(x);
        let own = found.iter().find(|(q, _)| *q == p);
        // One that is not around the place goes with a neighbour that is.
        let other = || found.iter().find(|(q, _)| held.hold(p, *q) == BondHold::Full);
        own.or_else(other).map_or(p, |it| it.1)
    }

    /// The vertex at a place of a point's cell.
    fn vertex(&mut self, x: &Vec3, p: u32) -> u32 {
        let name = self.name(x, p);
        let key = self.key(x);
        if let Some(&id) = self.known.get(&(key, name)) {
            return id;
        }
        let all = self.groups.get(&key).map_or(&[][..], |found| found);
        let own = all.iter().filter(|(_, other)| *other == name);
        let mut near: Vec<u32> = own.map(|it| it.0).collect();
        if near.is_empty() {
            near.push(p);
        }
        self.put(*x, name, &near)
    }

    /// The vertex at a place that those points carry.
    fn put(&mut self, rest: Vec3, name: u32, near: &[u32]) -> u32 {
        let key = (self.key(&rest), name);
        if let Some(&id) = self.known.get(&key) {
            return id;
        }
        let id = self.vertices.len() as u32;
        let rest = self.inner.get(&key.0).copied().unwrap_or(rest);
        let shares = shares(&rest, near, &self.template.rest);
        self.vertices.push(CarriedVertex { rest, shares });
        self.known.insert(key, id);
        id
    }
}

impl SurfaceTemplate {
    /// Whether all short bonds of a point hold, those across gaps aside.
    fn is_sound(&self, held: &HeldBonds, p: u32) -> bool {
        let reach = super::super::pieces::HOLDING * self.spacing;
        let x = self.rest[p as usize];
        held.row(p).iter().all(|&(q, holds)| {
            holds == BondHold::Full
                || (self.rest[q as usize] - x).norm() > reach
                || self.gaps.contains(&[p.min(q), p.max(q)])
        })
    }
}

/// Corners of polygons, to be found from the sides of others.
struct CornerCells {
    cell: f64,
    /// How near to a side a corner must be to lie on it \[m\].
    near: f64,
    cells: BTreeMap<[i64; 3], Vec<Vec3>>,
    known: BTreeSet<[i64; 3]>,
}

impl CornerCells {
    fn new(spacing: f64) -> Self {
        let (cell, near) = (0.5 * spacing, 2.0 * SAME * spacing);
        Self { cell, near, cells: BTreeMap::new(), known: BTreeSet::new() }
    }

    fn cell(&self, x: f64) -> i64 {
        (x / self.cell).floor() as i64
    }

    /// Adds a corner, unless there is one with that key.
    fn put(&mut self, key: [i64; 3], x: Vec3) {
        if self.known.insert(key) {
            let cell = [0, 1, 2].map(|axis| self.cell(x[axis]));
            self.cells.entry(cell).or_default().push(x);
        }
    }

    /// Adds the corners that lie between two places on the line through both, in order.
    fn between(&self, from: &Vec3, to: &Vec3, all: &mut Vec<Vec3>) {
        let along = to - from;
        let length = along.norm();
        if length <= 2.0 * self.near {
            return;
        }
        let (low, high) = (from.inf(to), from.sup(to));
        let [i, j, k] = [0, 1, 2]
            .map(|axis| self.cell(low[axis] - self.near)..=self.cell(high[axis] + self.near));
        let mut found: Vec<(f64, Vec3)> = Vec::new();
        for x in i {
            for y in j.clone() {
                for (_, places) in self.cells.range([x, y, *k.start()]..=[x, y, *k.end()]) {
                    for place in places {
                        let at = (place - from).dot(&along) / length;
                        let aside = (place - from - along * (at / length)).norm();
                        if aside <= self.near && at > self.near && at < length - self.near {
                            found.push((at, *place));
                        }
                    }
                }
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.extend(found.into_iter().map(|it| it.1));
    }
}
