//! What runs of programs read and write.

use crate::aligned::Aligned;

/// What runs read and write, for a number of states side by side, one in each lane. It belongs to the program that
/// made it.
#[derive(Clone, Debug)]
pub struct Memory {
    pub(crate) lanes: usize,
    pub(crate) slots: Aligned,
    pub(crate) scratch: Aligned,
}

impl Memory {
    /// With so many slots for each lane, and numbers of scratch.
    pub(crate) fn new(lanes: usize, slots: usize, scratch: usize) -> Self {
        Self { lanes, slots: Aligned::zeros(slots * lanes), scratch: Aligned::zeros(scratch) }
    }

    /// Sees to it that there is so much scratch.
    pub(crate) fn provide(&mut self, scratch: usize) {
        if self.scratch.len() < scratch {
            self.scratch = Aligned::zeros(scratch);
        }
    }

    /// Each lane has its flag: none is left as it was.
    #[inline]
    pub(crate) fn check_flags(&self, flags: &[bool]) {
        let (found, lanes) = (flags.len(), self.lanes);
        assert!(found >= lanes, "{found} flags for {lanes} lanes");
    }

    /// Writes a lane's inputs one after the other.
    #[inline]
    pub(crate) fn writer(&mut self, lane: usize) -> impl FnMut(&[f64]) + '_ {
        assert!(lane < self.lanes, "lane {lane} of {}", self.lanes);
        let (lanes, slots) = (self.lanes, &mut *self.slots);
        let mut next = lane;
        // One by one: programs read single numbers soon after, and would wait for wider pieces that overlap.
        move |values| {
            for value in values {
                slots[next] = *value;
                next += lanes;
            }
        }
    }

    /// What is in a slot.
    pub(crate) fn read(&self, slot: u32, lane: usize) -> f64 {
        self.slots[slot as usize * self.lanes + lane]
    }

    /// A joint's six numbers, of the slots of all joints one after the other.
    pub(crate) fn wrench(&self, slots: &[u32], lane: usize, joint: usize) -> [f64; 6] {
        core::array::from_fn(|i| self.read(slots[6 * joint + i], lane))
    }
}
