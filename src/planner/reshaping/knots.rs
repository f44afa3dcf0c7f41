//! From the knots of a motion to stations.

use super::going::Going;
use super::{POINTS, STATIONS};
use crate::machine::LEAST_CYCLE_SHARE;
use crate::number::vector::{dot, norm, sub};
use crate::number::{Coord, Scalar};
use crate::path::node::{Cell, Node, Programmed};
use crate::profile::law::{Law, PathState};
use crate::profile::window::Station;
use crate::reshape::{Bounds, Window};
use core::array::from_fn;
use core::ops::ControlFlow;
use heapless::Vec;

/// Halvings of a span, at most: where the motion is slow and turns, a cell is shorter.
const HALVINGS: u32 = 3;
/// Motions over a cell at other speeds than those that were found, with a rest at either end, that are looked at, by the Bernstein coefficients of their speed, at so many places; others may lie so many times as far
/// off. (By constant jerk the coefficient beside a rest would be 1 / 3.)
const OTHERS: [[f64; 4]; 6] = [
    [0.0, 0.0, 0.3, 1.0],
    [1.0, 0.3, 0.0, 0.0],
    [1.0, 1.0, 1.0, 1.0],
    [0.0, 0.0, 1.0, 0.1],
    [1.0, 0.0, 0.0, 1.0],
    [0.1, 1.0, 1.0, 0.1],
];
const LOOKS: u32 = 6;
const FARTHER: f64 = 1.25;
/// The true speed over a cell is at most so many times the greatest path speed, at any speeds: the feed bounds that alone.
const SWIFTER: f64 = 1.003;
/// What it exceeds that by may be so many times what is seen at the places that are looked at.
const UNSEEN: f64 = 1.25;
/// So many places, between those for how far it strays: a speed has narrower peaks.
const SPEED_LOOKS: u32 = 12;

/// What a motion becomes.
#[derive(Clone, Copy)]
pub struct Knotted {
    /// How many stations it replaces.
    pub replaced: usize,
    /// The station at which the next window begins, counted from the first, and its line.
    pub next: Option<(usize, usize)>,
}

/// Stations that are being made of a motion.
#[derive(Clone, Copy)]
pub struct Knotting<S: Scalar, const N: usize> {
    /// The span that is next, how often its cells are halved in the next try, its first station, and its line.
    k: usize,
    halvings: u32,
    from: Station<S, N>,
    line: usize,
    count: usize,
    /// The agreed cell beside which the next span begins, and the last one.
    beside: usize,
    last: usize,
    /// The station at its end, which is in the plan already with `rests`, and one that is to follow.
    end: Station<S, N>,
    rests: bool,
    middle: Option<Station<S, N>>,
    lie: Lie<S, N>,
    run: usize,
    found: Knotted,
}

impl<S: Scalar, const N: usize> Knotting<S, N> {
    /// Of a motion that was found from station `first` on, in place of others. With `rests` the motion ends in the rest at station
    /// `limit`, which stays. The next window begins after `run` spans.
    pub fn new<const NODES: usize>(
        window: &Window<S, N, POINTS>,
        going: &Going<'_, S, N, NODES>,
        (first, rests, limit): (usize, bool, usize),
        run: usize,
    ) -> Option<Self> {
        let from = *going.horizon.window.get(first)?;
        let (end, middle, replaced) = if rests {
            (*going.horizon.window.get(limit)?, None, limit - first)
        } else {
            let (cell, t) = going.cell(window.joins());
            let (end, middle) = joined(going, cell, t)?;
            (end, middle, cell + 1 - first)
        };
        let lie = Lie::new(window, going.origin, &end);
        let (count, found) = (window.spans(), Knotted { replaced, next: None });
        let (beside, last) = (first, first + replaced.saturating_sub(1));
        Some(Self {
            k: 0,
            halvings: 0,
            from,
            line: 0,
            count,
            beside,
            last,
            end,
            rests,
            middle,
            lie,
            run,
            found,
        })
    }

    /// Spans of the motion.
    pub const fn spans(&self) -> usize {
        self.count
    }

    /// Goes on with at most `most` tries to make cells of a span; breaks when all spans are done, or one cannot be made into cells that keep
    /// what they have to.
    ///
    /// Cost: of a try, up to 8 cells.
    pub fn go_on<const NODES: usize>(
        &mut self,
        window: &mut Window<S, N, POINTS>,
        going: &Going<'_, S, N, NODES>,
        bounds: &Bounds<'_, S, N>,
        most: usize,
        list: &mut Vec<Station<S, N>, STATIONS>,
    ) -> ControlFlow<Option<Knotted>> {
        for _ in 0..most {
            if self.k == self.count {
                let last = (!self.rests).then_some(self.end);
                let full = last.into_iter().chain(self.middle).any(|end| list.push(end).is_err());
                return ControlFlow::Break((!full).then_some(self.found));
            }
            if self.span(window, going, bounds, list).is_none() {
                return ControlFlow::Break(None);
            }
        }
        ControlFlow::Continue(())
    }

    fn span<const NODES: usize>(
        &mut self,
        window: &mut Window<S, N, POINTS>,
        going: &Going<'_, S, N, NODES>,
        bounds: &Bounds<'_, S, N>,
        list: &mut Vec<Station<S, N>, STATIONS>,
    ) -> Option<()> {
        if self.halvings == 0 {
            if self.k == self.run {
                self.found.next = Some((list.len(), self.line));
            }
            self.from.cell = Cell {
                length: S::ZERO,
                tangent_offset: [S::ZERO; N],
                programmed: self.programmed(window, going)?,
                dwell: S::ZERO,
                event: None,
                straight: false,
            };
        }
        let to = (self.k + 1 == self.count).then_some(self.end);
        let before = list.len();
        let made = span(window, going, &self.lie, (self.from, to), self.halvings, list);
        let Some(from) = made else {
            list.truncate(before);
            self.halvings += 1;
            return (self.halvings <= HALVINGS).then_some(());
        };
        (self.from, self.halvings) = (from, 0);
        self.lie.from += self.lie.per;
        self.line = window.advance(&Bounds { line: self.line, ..*bounds });
        self.k += 1;
        Some(())
    }

    /// What the blocks beside the next span ask for: the least feed of all of them, so that it is kept at any other speeds too, and the
    /// tag of the last, so that none is missed at the end.
    fn programmed<const NODES: usize>(
        &mut self,
        window: &Window<S, N, POINTS>,
        going: &Going<'_, S, N, NODES>,
    ) -> Option<Programmed<S>> {
        let stations = &going.horizon.window;
        let is_last = self.k + 1 == self.count;
        let (base, state) = window.within(S::ONE);
        let at = self.lie.place(&base, &state.position, S::ONE);
        let mut found = stations.get(self.beside)?.cell.programmed;
        while self.beside < self.last {
            let next = stations.get(self.beside + 1)?;
            let off: [S; N] = from_fn(|i| at[i].minus(next.node.at[i]));
            if !(is_last || dot(&off, &next.node.tangent) > S::ZERO) {
                break;
            }
            self.beside += 1;
            let programmed = next.cell.programmed;
            found = if programmed.feed < found.feed {
                programmed
            } else {
                Programmed { tag: programmed.tag, ..found }
            };
        }
        Some(found)
    }
}

/// The station where a cell of the agreed motion is joined `t` s after its start, and one in its middle if what is left reaches over
/// that: the jerk of a cell is bounded by that of its halves.
fn joined<S: Scalar, const N: usize, const NODES: usize>(
    going: &Going<'_, S, N, NODES>,
    cell: usize,
    t: S,
) -> Option<(Station<S, N>, Option<Station<S, N>>)> {
    let horizon = going.horizon;
    let (time, cycle) = (horizon.time(cell), horizon.config.cycle);
    if !(t > S::ZERO) {
        // At its very beginning.
        let station = *horizon.window.get(cell)?;
        return Some((Station { agreed: station.state, ..station }, None));
    }
    if !(time - t >= cycle * S::of(LEAST_CYCLE_SHARE)) {
        return None;
    }
    let behind = horizon.window.get(cell + 1)?;
    let mut station = horizon.station_on_the_way(cell, t)?;
    let half = time * S::of(0.5);
    let mut middle = None;
    if !station.cell.straight && half - t > cycle {
        let mut there = horizon.station_on_the_way(cell, half)?;
        station.lead_to(&there.node.at, there.state, half - t);
        if !horizon.keeps(&mut there, behind) || !horizon.keeps(&mut station, &there) {
            return None;
        }
        middle = Some(there);
    } else if !horizon.keeps(&mut station, behind) {
        return None;
    }
    Some((station, middle))
}

/// Where a motion lies.
#[derive(Clone, Copy)]
struct Lie<S, const N: usize> {
    /// What its positions are about.
    origin: [Coord; N],
    /// By how much it misses its end, in all: control points are rounded. What is missed is made good over all of it, span by span: over
    /// the last one alone it would be a jerk.
    missed: [S; N],
    /// Share of that at the start of the next span, and what is added over it.
    from: S,
    per: S,
}

impl<S: Scalar, const N: usize> Lie<S, N> {
    fn new(window: &Window<S, N, POINTS>, origin: [Coord; N], end: &Station<S, N>) -> Self {
        let (base, state) = window.end();
        let missed = from_fn(|i| {
            let at = origin[i].plus(base[i]).plus(state.position[i]);
            end.node.at[i].minus(at)
        });
        let per = S::ONE / S::from_u32(window.spans().max(1) as u32);
        Self { origin, missed, from: S::ZERO, per }
    }

    /// A place a share of the next span behind its start.
    fn place(&self, base: &[S; N], position: &[S; N], share: S) -> [Coord; N] {
        let made_good = self.from + share * self.per;
        from_fn(|i| self.origin[i].plus(base[i]).plus(position[i] + self.missed[i] * made_good))
    }
}

/// The stations of the next span, cut in 2^`halvings` cells, and the one behind them; `None` if a cell does not keep what it has to.
fn span<S: Scalar, const N: usize, const NODES: usize>(
    window: &Window<S, N, POINTS>,
    going: &Going<'_, S, N, NODES>,
    lie: &Lie<S, N>,
    (start, end): (Station<S, N>, Option<Station<S, N>>),
    halvings: u32,
    list: &mut Vec<Station<S, N>, STATIONS>,
) -> Option<Station<S, N>> {
    let parts = 1 << halvings;
    let part = S::ONE / S::from_u32(parts);
    let mut from = start;
    for k in 1..=parts {
        let to = match end {
            Some(end) if k == parts => end,
            _ => station(window, going, lie, &start, S::from_u32(k) * part)?,
        };
        from.agreed = from.state;
        from.lead_to(&to.node.at, to.state, window.knots() * part);
        let Strays { off, swifter } =
            strays([&from.node, &to.node], &from.cell, [from.state, to.state])?;
        let stays = off <= window.free() && swifter <= S::of(SWIFTER);
        if !(stays || to.rest) || !going.horizon.keeps(&mut from, &to) {
            return None;
        }
        list.push(from).ok()?;
        from = Station { cell: start.cell, ..to };
    }
    Some(from)
}

/// A motion over a cell, by the share of its time, whatever that is: every axis goes along the tangent at the cell's start as far as the
/// path does, and aside by a quintic ([`crate::profile::rows`]).
struct Paced<S> {
    /// Bernstein coefficients of the speed, in lengths of the cell over its time.
    speeds: [S; 4],
}

impl<S: Scalar> Paced<S> {
    fn new(speeds: [S; 4]) -> Self {
        let per = S::of(4.0) / (speeds[0] + speeds[1] + speeds[2] + speeds[3]);
        Self { speeds: speeds.map(|speed| speed * per) }
    }

    /// Share of the length that lies behind, and its change.
    fn along(&self, u: S) -> (S, S) {
        let [a, b, c, d] = self.speeds;
        let three = S::of(3.0);
        let (p, q, r) = (three * (b - a), three * (c - b - b + a), d - three * (c - b) - a);
        let (half, third, quarter) = (S::of(0.5), S::of(1.0 / 3.0), S::of(0.25));
        (
            u * (a + u * (p * half + u * (q * third + u * r * quarter))),
            a + u * (p + u * (q + u * r)),
        )
    }

    /// Factors of the offset, of the turn of the tangent, and of the curvatures at both ends in how far it goes aside.
    fn aside(&self, u: S, length: S) -> [S; 4] {
        let of = S::of;
        let cube = u * u * u;
        let shapes = [
            cube * (of(10.0) + u * (of(6.0) * u - of(15.0))),
            cube * (u * (of(7.0) - of(3.0) * u) - of(4.0)),
            u * u * (of(0.5) + u * (u * (of(1.5) - of(0.5) * u) - of(1.5))),
            cube * (of(0.5) + u * (of(0.5) * u - S::ONE)),
        ];
        self.factors(shapes, length)
    }

    /// Their change.
    fn turning(&self, u: S, length: S) -> [S; 4] {
        let of = S::of;
        let square = u * u;
        let shapes = [
            square * of(30.0) * (S::ONE + u * (u - of(2.0))),
            square * (u * (of(28.0) - of(15.0) * u) - of(12.0)),
            u * (S::ONE + u * (u * (of(6.0) - of(2.5) * u) - of(4.5))),
            square * (of(1.5) + u * (of(2.5) * u - of(4.0))),
        ];
        self.factors(shapes, length)
    }

    fn factors(&self, [offset, turn, start, end]: [S; 4], length: S) -> [S; 4] {
        let [first, _, before, last] = self.speeds;
        let end = end * length;
        [
            offset,
            turn * last * length + end * S::of(3.0) * (last - before),
            start * first * first * length * length,
            end * last * last * length,
        ]
    }

    /// The greatest path speed, in lengths of the cell over its time.
    fn greatest(&self) -> S {
        let [first, next, before, last] = self.speeds;
        first.greatest(next).greatest(before.greatest(last))
    }
}

/// What motions over a cell do that the path does not say.
struct Strays<S> {
    /// How far one at any other speeds may lie from that at its own, mm.
    off: S,
    /// The true speed at any of them, as a share of the greatest path speed.
    swifter: S,
}

/// That of a cell; `None` if there is no motion over it.
///
/// Cost: bounded by the other motions that are looked at, and the places of each.
fn strays<S: Scalar, const N: usize>(
    [from, to]: [&Node<S, N>; 2],
    cell: &Cell<S, N>,
    [start, end]: [PathState<S>; 2],
) -> Option<Strays<S>> {
    let law = Law::new(cell.length, start, end)?;
    let [early, late] = law.inner_speeds();
    let own = Paced::new([law.v0, early, late, law.v1]);
    let turn = sub(&to.tangent, &from.tangent);
    let mixed = |by: [S; 4]| -> [S; N] {
        from_fn(|i| {
            by[0] * cell.tangent_offset[i]
                + by[1] * turn[i]
                + by[2] * from.curvature[i]
                + by[3] * to.curvature[i]
        })
    };
    // The square of the true speed, in those units.
    let swift = |paced: &Paced<S>, u: S| {
        let (_, speed) = paced.along(u);
        let turning = mixed(paced.turning(u, cell.length)).map(|x| x / cell.length);
        let v: [S; N] = from_fn(|i| speed * from.tangent[i] + turning[i]);
        dot(&v, &v)
    };
    let looks = |count: u32| (1..count).map(move |look| S::from_u32(look) / S::from_u32(count));
    let swiftest = |paced: &Paced<S>| {
        let most = looks(SPEED_LOOKS).fold(S::ZERO, |most, u| most.greatest(swift(paced, u)));
        let greatest = paced.greatest();
        most / (greatest * greatest)
    };
    let mut swifter = swiftest(&own);
    // Square of it.
    let mut off = S::ZERO;
    for other in OTHERS {
        let other = Paced::new(other.map(S::of));
        swifter = swifter.greatest(swiftest(&other));
        for u in looks(LOOKS) {
            let (way, _) = other.along(u);
            // When its own motion has gone as far.
            let mut at = way;
            for _ in 0..4 {
                let (gone, speed) = own.along(at);
                let by = (way - gone) / speed.greatest(S::of(0.05));
                at = (at + by).greatest(S::ZERO).least(S::ONE);
            }
            let (a, b) = (other.aside(u, cell.length), own.aside(at, cell.length));
            let apart = mixed(from_fn(|k| a[k] - b[k]));
            off = off.greatest(dot(&apart, &apart));
        }
    }
    // Near 1 a square exceeds it twice as far.
    let beyond = (swifter - S::ONE) * S::of(0.5 * UNSEEN);
    Some(Strays { off: off.sqrt() * S::of(FARTHER), swifter: S::ONE + beyond })
}

/// A station a share of the next span behind its start.
fn station<S: Scalar, const N: usize, const NODES: usize>(
    window: &Window<S, N, POINTS>,
    going: &Going<'_, S, N, NODES>,
    lie: &Lie<S, N>,
    like: &Station<S, N>,
    share: S,
) -> Option<Station<S, N>> {
    let (base, state) = window.within(share);
    let speed = norm(&state.velocity);
    if !(speed > going.horizon.crawl()) {
        return None;
    }
    let tangent = state.velocity.map(|v| v / speed);
    let along = dot(&state.acceleration, &tangent);
    let at = lie.place(&base, &state.position, share);
    let curvature = from_fn(|i| (state.acceleration[i] - along * tangent[i]) / (speed * speed));
    let found = PathState { b: speed * speed, a: along };
    Some(Station {
        node: Node { at, tangent, curvature },
        rest: false,
        pause: false,
        state: found,
        agreed: found,
        ..*like
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::ArcLength;
    use crate::number::serial::NodeSerial;
    use crate::profile::compile::{Placement, piece};
    use crate::profile::rows::View;
    use crate::servo::piece::Sequel;
    use crate::{AxisLimits, Limits};
    use std::vec::Vec as List;

    type Place = [f64; 2];

    /// The way over a cell, at speeds with these Bernstein coefficients; and the greatest true speed, as a share of the greatest of them.
    fn way(view: &View<'_, f64, 2>, [p0, p1, p2, p3]: [f64; 4]) -> (List<Place>, f64) {
        let time = 4.0 * view.cell.length / (p0 + p1 + p2 + p3);
        let [start, end] = [(p0, p1 - p0), (p3, p3 - p2)]
            .map(|(v, gain)| PathState { b: v * v, a: gain * 3.0 / time });
        let Some(law) = Law::new(view.cell.length, start, end) else { return (List::new(), 0.0) };
        let (arc_length, sequel) = (ArcLength::ZERO, Sequel::Motion);
        let piece = piece(view, &law, Placement { serial: NodeSerial::ZERO, arc_length, sequel });
        let shown = || (0..=48).map(|k| piece.at(law.time * f64::from(k) / 48.0));
        let [early, late] = law.inner_speeds();
        let greatest = law.v0.max(law.v1).max(early).max(late);
        let swiftest = shown().map(|at| norm(&at.velocity)).fold(0.0, f64::max);
        (shown().map(|at| [at.position_mm(0), at.position_mm(1)]).collect(), swiftest / greatest)
    }

    /// How far the farthest of some places lies from a way.
    fn off(places: &[Place], way: &[Place]) -> f64 {
        let from = |x: &Place| {
            way.windows(2)
                .map(|pair| {
                    let (d, off) = (sub(&pair[1], &pair[0]), sub(x, &pair[0]));
                    let share = dot(&d, &off) / dot(&d, &d).max(1.0e-30);
                    norm(&sub(&off, &d.map(|d| d * share.clamp(0.0, 1.0))))
                })
                .fold(f64::INFINITY, f64::min)
        };
        places.iter().map(from).fold(0.0, f64::max)
    }

    #[test]
    fn other_motions_over_a_cell_are_as_near_and_as_slow_as_is_said() {
        let limits = Limits::new([AxisLimits::linear(1.0, 1.0, 1.0); 2]).unwrap();
        let mut state = 0x9E37_79B9_7F4A_7C15u64;
        let mut next = |from: f64, to: f64| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            from + (to - from) * (state >> 11) as f64 / (1u64 << 53) as f64
        };
        for _ in 0..4000 {
            let h = 8.0e-3 / [1.0, 2.0, 4.0][(next(0.0, 3.0)) as usize];
            let v = [10f64.powf(next(0.0, 2.2)), 0.0];
            let a: Place = [next(-2500.0, 2500.0), next(-2500.0, 2500.0)];
            let j: Place = [next(-5.0e4, 5.0e4), next(-5.0e4, 5.0e4)];
            let end: [Place; 3] = [
                from_fn(|i| h * (v[i] + h * (a[i] / 2.0 + h * j[i] / 6.0))),
                from_fn(|i| v[i] + h * (a[i] + h * j[i] / 2.0)),
                from_fn(|i| a[i] + h * j[i]),
            ];
            let node = |at: Place, v: Place, a: Place| {
                let speed = norm(&v);
                let tangent = v.map(|v| v / speed);
                let along = dot(&a, &tangent);
                let curvature = from_fn(|i| (a[i] - along * tangent[i]) / (speed * speed));
                let at = at.map(|x| Coord::from_mm(x).unwrap());
                (Node { at, tangent, curvature }, speed, along)
            };
            let (from, v0, a0) = node([0.0; 2], v, a);
            let (to, v1, a1) = node(end[0], end[1], end[2]);
            let speeds = [v0, v0 + a0 * h / 3.0, v1 - a1 * h / 3.0, v1];
            if speeds.iter().any(|v| *v < 0.5) {
                continue;
            }
            let length = h * speeds.iter().sum::<f64>() / 4.0;
            let cell = Cell {
                length,
                tangent_offset: from_fn(|i| end[0][i] - length * from.tangent[i]),
                programmed: Programmed::feed(1.0),
                dwell: 0.0,
                event: None,
                straight: false,
            };
            let view = View::unbound([&from, &to], &cell, &limits);
            let (own, swiftest) = way(&view, speeds);
            let state = |v: f64, a: f64| PathState { b: v * v, a };
            let Strays { off: kept, swifter } =
                strays([&from, &to], &cell, [state(v0, a0), state(v1, a1)]).unwrap();
            // Of what is refused anyway no more is said.
            let most = if swifter > SWIFTER { f64::INFINITY } else { SWIFTER };
            assert!(swiftest <= most, "{swiftest}: {speeds:?}");
            let (x, y, z) = (next(0.25, 1.0), next(0.0, 1.0), next(0.0, 1.0));
            for other in
                [[0.0, 0.0, x, 1.0], [1.0, x, 0.0, 0.0], [1.0, x, y, z], [x, y, z, 1.0], [1.0; 4]]
            {
                let (places, swiftest) = way(&view, other);
                assert!(swiftest <= most, "{swiftest}: {speeds:?} and {other:?}");
                let found = off(&places, &own);
                assert!(found <= kept + 1.0e-6, "{found} of {kept}: {speeds:?} and {other:?}");
            }
        }
    }
}
