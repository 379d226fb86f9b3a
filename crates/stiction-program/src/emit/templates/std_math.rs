/// Mathematical functions of the standard library.
struct Std;

impl Math for Std {
    fn sqrt(x: Real) -> Real {
        x.sqrt()
    }
    fn sin_cos(x: Real) -> (Real, Real) {
        x.sin_cos()
    }
    fn exp(x: Real) -> Real {
        x.exp()
    }
    fn ln(x: Real) -> Real {
        x.ln()
    }
    fn atan2(y: Real, x: Real) -> Real {
        y.atan2(x)
    }
}
