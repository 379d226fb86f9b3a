//! Order of the integration method of a step.
//!
//! Samples of a controller end steps long before accuracy requires it. Methods of order four or
//! five then meet the tolerance with fewer evaluations of accelerations than the method of order
//! eight.

use super::Simulation;
use super::method_change::DENSE;
use super::singular::NEAR;
use crate::forward::instant::Instant;
use crate::forward::integrator::Order;

/// Lower orders, from the fewest evaluations on.
const LOWER: [Order; 2] = [Order::Four, Order::Five];
/// Largest estimated error of a step of lower order, as a fraction of the tolerated error. Steps of
/// lower order are much shorter than the tolerance permits at order eight, so that more of their
/// errors add up.
const PART: f64 = 0.1;
/// Growth of the longest step of a lower order in each step of a higher order. A method is
/// therefore tried again about ten steps after it has failed narrowly.
const REGAINED: f64 = 1.05;

impl Simulation<'_> {
    /// Returns the order of the method for a step of the length `step`, s. `is_cut` is true if the
    /// step ends at a change of the inputs; all other steps are of order eight. Steps near singular
    /// configurations, and steps that stability may limit, are also of order eight.
    pub(super) fn order_of_step(&mut self, step: f64, is_cut: bool) -> Order {
        // The error estimate of order four does not see derivatives that depend on time alone, as
        // those of internal states of the inputs may.
        let lowest = usize::from(!self.input.values.is_empty());
        let is_short = is_cut && step < self.step && step >= DENSE;
        if !is_short || self.now.distance < NEAR || self.workspace.crosses.is_some() {
            return Order::Eight;
        }
        for (order, longest) in LOWER.into_iter().zip(&mut self.longest_of_lower_order).skip(lowest)
        {
            if step <= *longest {
                return order;
            }
            *longest *= REGAINED;
        }
        Order::Eight
    }

    /// Returns false if a step must be repeated at a higher order because its estimated error
    /// exceeds the part of the tolerated error that steps of lower order may have. `error` is the
    /// estimated error divided by the tolerated error.
    pub(super) fn accepts_order(&mut self, order: Order, error: f64, step: f64) -> bool {
        // The error of a step of order four is known at its end.
        let (place, exponent) = match order {
            Order::Four | Order::Eight => return true,
            Order::Five => (1, 5.0),
        };
        self.accepts(place, error, (step, exponent))
    }

    /// Returns false if a step of order four that ends at `arrived` must be repeated at a higher
    /// order, see [`Self::accepts_order`].
    pub(super) fn accepts_end(&mut self, arrived: &Instant, step: f64) -> bool {
        if self.steps.order() != Order::Four {
            return true;
        }
        let mut after = self.list();
        self.derivative_into(arrived, &mut after);
        let error = self.steps.error_of_order_3(&after, &self.tolerance(&self.scales));
        self.lists.push(after);
        let error = error * self.settings.relative / self.attainable_tolerance();
        self.accepts(0, error, (step, 4.0))
    }

    /// Updates the longest step of a lower order from the error of a step, which is proportional to
    /// the power `exponent` of its length.
    fn accepts(&mut self, place: usize, error: f64, (step, exponent): (f64, f64)) -> bool {
        let part = error / PART;
        let grow = if part.is_nan() { 0.0 } else { 0.9 * part.powf(-1.0 / exponent) };
        self.longest_of_lower_order[place] = step * grow.clamp(0.2, 6.0);
        part <= 1.0
    }
}
