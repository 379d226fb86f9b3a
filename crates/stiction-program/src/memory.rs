//! Memory for the inputs, results and scratch values of programs.

use crate::aligned::Aligned;

/// Inputs, results and scratch values of a program, for one state or for several states in parallel
/// lanes. The memory can be used only with the program that allocated it.
#[derive(Clone, Debug)]
pub struct Memory {
    pub(crate) lanes: usize,
    pub(crate) slots: Aligned,
    pub(crate) scratch: Aligned,
}

impl Memory {
    /// Allocates memory with `slots` slots for each lane and `scratch` scratch values.
    pub(crate) fn new(lanes: usize, slots: usize, scratch: usize) -> Self {
        Self { lanes, slots: Aligned::zeros(slots * lanes), scratch: Aligned::zeros(scratch) }
    }

    /// Enlarges the scratch memory to `scratch` values if it is smaller.
    pub(crate) fn provide(&mut self, scratch: usize) {
        if self.scratch.len() < scratch {
            self.scratch = Aligned::zeros(scratch);
        }
    }

    /// Panics if `flags` has fewer entries than the memory has lanes, because the results of the
    /// remaining lanes could not be reported.
    #[inline]
    pub(crate) fn check_flags(&self, flags: &[bool]) {
        let (found, lanes) = (flags.len(), self.lanes);
        assert!(found >= lanes, "{found} flags for {lanes} lanes");
    }

    /// Returns a function that writes values to consecutive inputs of a lane, beginning with the
    /// first input.
    #[inline]
    pub(crate) fn writer(&mut self, lane: usize) -> impl FnMut(&[f64]) + '_ {
        assert!(lane < self.lanes, "lane {lane} of {}", self.lanes);
        let (lanes, slots) = (self.lanes, &mut *self.slots);
        let mut next = lane;
        // Single writes: programs read single numbers soon after, and overlapping wider writes
        // would delay these reads.
        move |values| {
            for value in values {
                slots[next] = *value;
                next += lanes;
            }
        }
    }

    /// Reads the number in a slot of one lane.
    pub(crate) fn read(&self, slot: u32, lane: usize) -> f64 {
        self.slots[slot as usize * self.lanes + lane]
    }

    /// Reads the six components of a joint's wrench. `slots` lists the slots of the wrench
    /// components of all joints, joint by joint.
    pub(crate) fn wrench(&self, slots: &[u32], lane: usize, joint: usize) -> [f64; 6] {
        core::array::from_fn(|i| self.read(slots[6 * joint + i], lane))
    }
}
