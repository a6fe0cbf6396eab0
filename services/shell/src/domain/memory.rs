//! What a shell remembers, as bytes: all that its next steps depend on beside what it was made of.

use super::state::ShellDomain;
use crate::kernel::{CellSide, PointSetup, ShellKernel, SurfaceStrain};
use crate::section::{CrackLine, CrackSoftening, PointState, StationFlow};
use cullet_continuum::{StateReader, StateWriter};
use cullet_geometry::Vec3;
use cullet_model::Refusal;
use cullet_simd::{LANES, Real};
use std::collections::BTreeMap;

/// Most control points and elements over those at the start: every point has its own.
const MOST_COPIES: usize = 64;

impl<R: Real, const N: usize> ShellDomain<R, N> {
    /// Writes what differs from `fresh`, which this shell began as.
    pub(crate) fn write(&self, fresh: &Self, bytes: &mut StateWriter) {
        let first = fresh.mass.len();
        bytes.short(self.mass.len() as u32);
        self.origin[first..].iter().for_each(|&origin| bytes.short(origin));
        if self.mass.len() > first {
            self.mass.iter().for_each(|&mass| bytes.real(mass));
        }
        self.displacement.iter().for_each(|u| u[..3].iter().for_each(|&c| bytes.real(c)));
        self.velocity.iter().flatten().for_each(|&c| bytes.real(c));
        self.write_front(bytes);
        self.write_links(bytes);
        self.write_elements(fresh, bytes);
        let changed: Vec<usize> = self
            .live()
            .filter(|&p| {
                let mut own = self.state(p).clone();
                own.flaw = fresh.state(p).flaw;
                own != *fresh.state(p)
            })
            .collect();
        bytes.short(changed.len() as u32);
        for p in changed {
            bytes.short(p as u32);
            write_point(self.state(p), bytes);
        }
    }

    fn write_front(&self, bytes: &mut StateWriter) {
        let front = &self.front;
        bytes.number(front.steps);
        bytes.short(front.due.len() as u32);
        for (&step, points) in &front.due {
            bytes.number(step);
            bytes.short(points.len() as u32);
            for &(point, strength) in points {
                bytes.short(point);
                bytes.real(strength);
            }
        }
        bytes.short(front.changed.len() as u32);
        front.changed.iter().for_each(|&point| bytes.short(point));
    }

    fn write_links(&self, bytes: &mut StateWriter) {
        let links = &self.links;
        for bits in links.severed.chunks(8) {
            bytes.0.push((0..bits.len()).fold(0, |byte, k| byte | u8::from(bits[k]) << k));
        }
        for list in [&links.facing, &links.second] {
            let set: Vec<usize> = (0..list.len()).filter(|&p| list[p] != Vec3::zeros()).collect();
            bytes.short(set.len() as u32);
            for p in set {
                bytes.short(p as u32);
                list[p].iter().for_each(|&c| bytes.real(c));
            }
        }
        let dead: Vec<usize> = (0..links.dead.len()).filter(|&p| links.dead[p]).collect();
        bytes.short(dead.len() as u32);
        dead.into_iter().for_each(|p| bytes.short(p as u32));
    }

    fn write_elements(&self, fresh: &Self, bytes: &mut StateWriter) {
        let same = self.elements == fresh.elements && self.point_at == fresh.point_at;
        bytes.0.push(u8::from(!same));
        if same {
            return;
        }
        bytes.short(self.elements.len() as u32);
        for element in &self.elements {
            bytes.short(element.table);
            bytes.short(u32::from(element.live));
            element.nodes.iter().for_each(|&node| bytes.short(node));
        }
        self.point_at.iter().for_each(|&point| bytes.short(point));
        bytes.short(self.split.vacant.len() as u32);
        for (&table, places) in &self.split.vacant {
            bytes.short(table);
            bytes.short(places.len() as u32);
            places.iter().for_each(|&place| bytes.short(place));
        }
    }

    /// The shell that bytes tell of, which began as `fresh`.
    ///
    /// # Errors
    /// If they are cut short or hold what no shell does.
    pub(crate) fn read(fresh: &Self, reader: &mut StateReader<'_>) -> Result<Self, Refusal> {
        let mut shell = fresh.clone();
        let first = fresh.mass.len();
        let count = reader.short()? as usize;
        if count < first || count > MOST_COPIES * first {
            return Err(reader.foreign(&format!("it has {count} control points")));
        }
        for _ in first..count {
            let origin = reader.short()?;
            if origin as usize >= fresh.surface.nodes.len() {
                return Err(reader.foreign("a copy has no original"));
            }
            shell.origin.push(origin);
        }
        shell.mass.resize(count, 0.0);
        if count > first {
            for mass in &mut shell.mass {
                *mass = reader.real()?;
            }
        }
        if !shell.mass.iter().all(|m| m.is_finite() && *m > 0.0) {
            return Err(reader.foreign("a control point has no mass"));
        }
        shell.displacement.resize(count, [0.0; 4]);
        shell.velocity.resize(count, Vec3::zeros());
        shell.external = vec![Vec3::zeros(); count];
        for u in &mut shell.displacement {
            for c in &mut u[..3] {
                *c = reader.real()?;
            }
        }
        for c in shell.velocity.iter_mut().flatten() {
            *c = reader.real()?;
        }
        shell.read_front(reader)?;
        shell.read_links(reader)?;
        shell.read_elements(reader)?;
        for _ in 0..reader.short()? {
            let p = shell.point(reader)?;
            let seat = shell.seats[p];
            read_point(&mut shell.states[seat], reader)?;
        }
        (0..shell.states.len()).for_each(|seat| shell.watch(seat));
        Ok(shell)
    }

    /// The next number, of a point.
    fn point(&self, reader: &mut StateReader<'_>) -> Result<usize, Refusal> {
        let point = reader.short()? as usize;
        match point < self.points() {
            true => Ok(point),
            false => Err(reader.foreign(&format!("it names the point {point}"))),
        }
    }

    fn read_front(&mut self, reader: &mut StateReader<'_>) -> Result<(), Refusal> {
        self.front.steps = reader.number()?;
        self.front.due.clear();
        for _ in 0..reader.short()? {
            let step = reader.number()?;
            let mut list = Vec::new();
            for _ in 0..reader.short()? {
                let point = self.point(reader)? as u32;
                list.push((point, reader.real()?));
            }
            self.front.due.insert(step, list);
        }
        self.front.changed.clear();
        for _ in 0..reader.short()? {
            let point = self.point(reader)? as u32;
            self.front.changed.push(point);
        }
        Ok(())
    }

    fn read_links(&mut self, reader: &mut StateReader<'_>) -> Result<(), Refusal> {
        let marks = reader.take(self.links.severed.len().div_ceil(8))?;
        for (k, severed) in self.links.severed.iter_mut().enumerate() {
            *severed = marks[k / 8] >> (k % 8) & 1 == 1;
        }
        for which in 0..2 {
            for _ in 0..reader.short()? {
                let p = self.point(reader)?;
                let normal = Vec3::new(reader.real()?, reader.real()?, reader.real()?);
                if !(normal.norm() - 1.0).abs().le(&1e-6) {
                    return Err(reader.foreign("a crack has no normal"));
                }
                let list = if which == 0 { &mut self.links.facing } else { &mut self.links.second };
                list[p] = normal;
            }
        }
        for _ in 0..reader.short()? {
            let p = self.point(reader)?;
            self.links.dead[p] = true;
        }
        Ok(())
    }

    fn read_elements(&mut self, reader: &mut StateReader<'_>) -> Result<(), Refusal> {
        if reader.take(1)?[0] == 0 {
            return Ok(());
        }
        let (each, count) = (self.surface.points_per_cell(), reader.short()? as usize);
        let first = self.elements.len();
        let odd = || "its cells are not what cracks make of them".to_owned();
        if count < first || count > MOST_COPIES * first || !count.is_multiple_of(LANES) {
            return Err(reader.foreign(&odd()));
        }
        let mut elements = Vec::with_capacity(count);
        for _ in 0..count {
            let (table, live) = (reader.short()?, reader.short()?);
            let mut nodes = [0; N];
            for node in &mut nodes {
                *node = reader.short()?;
            }
            let fits = (table as usize) < self.surface.tables.len()
                && live >> each == 0
                && nodes.iter().all(|&n| (n as usize) < self.mass.len());
            if !fits {
                return Err(reader.foreign(&odd()));
            }
            elements.push(CellSide { nodes, table, live: live as u16 });
        }
        self.elements = elements;
        self.place_points(reader)?;
        let mut vacant: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for _ in 0..reader.short()? {
            let table = reader.short()?;
            let mut places = Vec::new();
            for _ in 0..reader.short()? {
                places.push(reader.short()?);
            }
            if !places.iter().all(|&e| self.elements.get(e as usize).is_some_and(|e| e.live == 0)) {
                return Err(reader.foreign(&odd()));
            }
            vacant.insert(table, places);
        }
        self.split.vacant = vacant;
        let (tables, level) = (&self.surface.tables, self.kernel.level());
        let nodes = self.mass.len();
        self.kernel = ShellKernel::new(tables, &self.elements, &self.setup, nodes, level);
        Ok(())
    }

    /// Reads which point is at which seat, and puts them there.
    fn place_points(&mut self, reader: &mut StateReader<'_>) -> Result<(), Refusal> {
        let each = self.surface.points_per_cell();
        let seats = self.elements.len() * each;
        let before = (self.setup.clone(), self.states.clone(), self.seats.clone());
        let (setup, states): (PointSetup, PointState) = (before.0[0], before.1[0].clone());
        self.setup.resize(seats, setup);
        self.states.resize(seats, states);
        self.point_at = vec![u32::MAX; seats];
        let mut met = vec![false; before.2.len()];
        for seat in 0..seats {
            let point = reader.short()?;
            let is_live = self.elements[seat / each].live >> (seat % each) & 1 == 1;
            if !is_live && point == u32::MAX {
                continue;
            }
            let p = point as usize;
            let same_table = p < met.len()
                && self.surface.cells[p / each].table == self.elements[seat / each].table;
            if !is_live || !same_table || p % each != seat % each || met[p] {
                return Err(reader.foreign("its points are not where cracks leave them"));
            }
            met[p] = true;
            self.setup[seat] = before.0[before.2[p]];
            self.states[seat] = before.1[before.2[p]].clone();
            (self.point_at[seat], self.seats[p]) = (point, seat);
        }
        match (0..met.len()).all(|p| met[p] || before.2[p] == usize::MAX) {
            true => Ok(()),
            false => Err(reader.foreign("it has lost a point")),
        }
    }
}

fn write_strain(strain: Option<&SurfaceStrain>, bytes: &mut StateWriter) {
    bytes.0.push(u8::from(strain.is_some()));
    let all = strain.into_iter().flat_map(|s| s.membrane.into_iter().chain(s.bending));
    all.for_each(|c| bytes.real(c));
}

fn read_strain(reader: &mut StateReader<'_>) -> Result<Option<SurfaceStrain>, Refusal> {
    if reader.take(1)?[0] == 0 {
        return Ok(None);
    }
    let mut strain = SurfaceStrain::default();
    for c in strain.membrane.iter_mut().chain(&mut strain.bending) {
        *c = finite(reader)?;
    }
    Ok(Some(strain))
}

fn finite(reader: &mut StateReader<'_>) -> Result<f64, Refusal> {
    let value = reader.real()?;
    if value.is_finite() { Ok(value) } else { Err(reader.foreign("a number is not finite")) }
}

fn write_point(state: &PointState, bytes: &mut StateWriter) {
    bytes.real(state.damage);
    bytes.real(state.tip);
    let flags = [state.dead, state.crossed, state.crumbles, state.crack.is_some()];
    bytes.0.push(flags.iter().enumerate().fold(0, |byte, (k, &f)| byte | u8::from(f) << k));
    if let Some(crack) = &state.crack {
        let [x, y] = crack.normal;
        let (worst, mean) = (crack.worst, crack.mean);
        let all = [x, y, crack.bending_share, crack.side, worst.hardness, worst.strength];
        all.into_iter().chain([mean.hardness, mean.strength]).for_each(|c| bytes.real(c));
    }
    bytes.short(state.flow.len() as u32);
    for flow in &state.flow {
        flow.strain.iter().for_each(|&c| bytes.real(c));
        bytes.real(flow.amount);
        bytes.real(flow.hardened);
    }
    write_strain(state.set.as_ref(), bytes);
    write_strain(state.last.as_ref(), bytes);
}

fn read_point(state: &mut PointState, reader: &mut StateReader<'_>) -> Result<(), Refusal> {
    state.damage = reader.real()?;
    state.tip = reader.real()?;
    let flags = reader.take(1)?[0];
    let is_strength = state.tip > 0.0;
    if !(0.0..=1.0).contains(&state.damage) || !is_strength || flags > 15 {
        return Err(reader.foreign(&format!("a damage is {}", state.damage)));
    }
    let flag = |k: u8| flags >> k & 1 == 1;
    (state.dead, state.crossed, state.crumbles) = (flag(0), flag(1), flag(2));
    if flag(3) {
        let normal = [finite(reader)?, finite(reader)?];
        let (bending_share, side) = (finite(reader)?, finite(reader)?);
        let mut softening = || -> Result<CrackSoftening, Refusal> {
            Ok(CrackSoftening { hardness: finite(reader)?, strength: finite(reader)? })
        };
        let (worst, mean) = (softening()?, softening()?);
        state.crack = Some(CrackLine { normal, bending_share, side, worst, mean });
    }
    let stations = reader.short()?;
    if stations > 16 {
        return Err(reader.foreign(&format!("a point has {stations} stations")));
    }
    state.flow.clear();
    for _ in 0..stations {
        let strain = [finite(reader)?, finite(reader)?, finite(reader)?];
        state.flow.push(StationFlow { strain, amount: finite(reader)?, hardened: finite(reader)? });
    }
    state.set = read_strain(reader)?;
    state.last = read_strain(reader)?;
    Ok(())
}
