"""Tolerances: the numerical constants by subject, each with its reason.

A computed number counts as zero when it is no larger than its rounding noise. The noise is computed with the data
(``linalg.rank``, ``linalg.staircase``) from half a unit in the last place of every entry of the input, so that no decision
needs an absolute threshold and none depends on units. Constants of speed and of memory stay with their algorithms.
"""

from __future__ import annotations

import numpy as np

# Rounding.

#: Spacing of float64 numbers relative to their size.
EPS = float(np.finfo(float).eps)

#: Decimal digits that determine a float64 number.
FLOAT64_DIGITS = 17

#: The computed noise is of first order, one rounding error each; over the steps of a staircase true errors reached ten times
#: that in experiments. A number below this many times its noise counts as zero.
NOISE_SAFETY = 16.0


def noise_of(size, count: int = 1):
    """Rounding noise of a sum of ``count`` terms of magnitude ``size``."""
    return NOISE_SAFETY * EPS * max(count, 1) ** 0.5 * size


# Rank decisions.

#: A rank decision is clear when the smallest kept value is this many times above that bound, and the largest dropped one
#: below this share of it, near its noise itself; other decisions are reported.
CLEAR_KEPT, CLEAR_DROPPED = 1e3, 0.1

# Eigenvalues.

#: Largest entry norm of a decoupling transformation between two blocks of J. A larger bound separates closer eigenvalues, a
#: smaller one loses fewer digits; clusters up to this bound are evaluated as one block instead.
DECOUPLING_LIMIT = 1e3

#: Two eigenvalues are one of higher multiplicity when they differ by less than this many noise radii.
CLUSTER_SAFETY = 1e3


def rounding_radius(multiplicity: int) -> float:
    """The largest relative change of the parts of an eigenvalue of this multiplicity by rounding errors of the data."""
    return (CLUSTER_SAFETY * EPS) ** (1 / multiplicity)


# Twice the digits (``linalg.double_double``).

#: Below this number products lose digits by underflow.
LEAST_NUMBER = 1e-270

# Precise arithmetic (``linalg.precise``).

#: Digits of precise arithmetic. A stiffness ratio of 1e16 takes 16 digits of the slowest motion away, its elimination and the
#: couplings between fast and slow motions about as many again; this leaves more than float64 holds, also
#: where multiple eigenvalues take most of the digits of their perturbation. Five words of 64 bits hold them.
PRECISE_DIGITS = 96

#: Digits that the eigenvalues of precise matrices are computed with, in turn, until they resolve the slowest one: what float64 can
#: hold spans up to 600 orders of magnitude.
PRECISE_LEVELS = (PRECISE_DIGITS, 4 * PRECISE_DIGITS, 8 * PRECISE_DIGITS)

#: Digits that the vectors of multiple eigenvalues of precise matrices may lose: the perturbation that separates them is so many
#: digits above rounding errors, and as many below the slowest eigenvalue.
PRECISE_GUARD_DIGITS = 36

#: Most QR steps for each eigenvalue of a precise matrix: convergence to a multiple eigenvalue is linear until they are separated.
QR_STEPS = 1000

#: Largest ratio of the couplings of a complex pair: one that is stretched more is nearly a double eigenvalue on the real axis.
STRETCH_LIMIT = 1e4

#: Relative rounding error of one precise operation.
PRECISE_EPS = 10.0 ** (2 - PRECISE_DIGITS)

#: Precise blocks are decoupled to this, far below float64, so that what is neglected of fast motions is negligible next to slow
#: ones; bases and inverses are right to as much.
PRECISE_DECOUPLING = 1e-30

#: More states are not computed in precise arithmetic: 120 take a quarter of a minute, these two minutes.
PRECISE_STATES = 240

#: Losing this many digits in float64 is not worth precise arithmetic, nor one more for every so many states (cubic time).
WORTHWHILE_DIGITS, WORTHWHILE_STATES_PER_DIGIT = 2, 12

# Matrices, eigenvalues and exponentials (``linalg``, ``polynomial``).

#: Entries of a quotient of matrices below this part of their terms, which have lost four digits, are computed with twice the digits.
CANCELLED = EPS**0.25

#: Condition up to which a matrix is not brought to better scales: at most two digits are at stake.
GOOD_CONDITION = 100.0

#: A preferred row becomes a pivot where its entry is at most this many times smaller than the largest.
PIVOT_PREFERENCE = 30.0

#: Rows and columns whose sizes differ by less than this ratio are balanced: units are powers of two.
BALANCE_RATIO = 1.5

#: Modes this many times larger than the states that they add up to are taken in clusters: as many digits would cancel.
MODE_AMPLIFICATION = 1e4

#: The bound for models of few states, for which the general method costs little: two digits.
REDUCED_AMPLIFICATION = 100.0

#: Couplings below this part of the rates of both states are weak, of the faster one where the rates differ by more: such groups are
#: decoupled each for itself, then from each other entry by entry. LAPACK keeps thirteen digits of a coupling of this size.
WEAK_COUPLING = 2.0**-10

#: Most steps of that: each gains a factor of weak coupling over the distance of rates.
SEPARATION_STEPS = 60

#: Condition of the lowest coefficients of all rows beyond which a body may be unconstrained, which rank decisions settle.
STIFFNESS_CONDITION = 1e10

#: Condition, rows and columns brought to one size, up to which a matrix is divided by: as many digits may be lost.
DIVISOR_CONDITION = 1e4

#: The rank of a stiffness matrix is clear where no pivot lies between rounding error and this share of the largest.
FREE_MOTION_GAP = EPS**0.5

#: Supports of a free body up to this part of the largest stiffness, those that rounding errors of assembled entries make, change the
#: shapes of a symmetric model by so little that its square is negligible.
ROUNDING_SUPPORT = EPS**0.75

#: A free body that dampers slow down at less than this part of the rates of its own motions is separated from these by iteration, as a
#: slow motion; its conserved number is one of large displacements otherwise, and nearly parallel to others.
SLOWED_RATE = 1e-4

#: Entries of a free motion nearer than this to whole numbers are tried as these.
INTEGER_DISTANCE = EPS**0.5

#: Multiplicities for which separate eigenvalues are joined on trial; within one block any multiplicity is.
JOINED_MULTIPLICITIES = range(2, 7)

#: Where the ranks are not those of one eigenvalue they are tried again with the rounding error multiplied by these.
RANK_TRIALS = (1.0, 10.0, 100.0, CLUSTER_SAFETY)

#: Up to this many states the pairs of the data taken exactly are computed in precise arithmetic: a quarter of a second.
AS_WRITTEN_STATES = 24

#: A number of so many binary digits is meant as written; rounded results have more, but for one in 2^27.
SHORT_BITS = 26

#: Up to this many states the Kronecker form of the data taken exactly is computed in precise arithmetic: some seconds.
PRECISE_KRONECKER_STATES = 60

#: Where the stiffnesses of modes have a larger ratio, undamped modes are refined: their shapes have lost six digits.
REFINED_SPREAD = 1e6

#: Condition of a positive definite stiffness matrix, its diagonal brought to 1, up to which refined modes resolve the softest motion.
REFINED_CONDITION = 1e-3 / EPS

#: Refined shapes have converged with a correction below the first, whose square is negligible; above the other, groups combine first.
LAST_CORRECTION, LARGEST_CORRECTION = EPS**0.5, 0.1

#: Where the moduli of all eigenvalues are within this ratio nothing cancels in the generator, and they need no refinement.
SIMILAR_EIGENVALUES = 4.0

#: Degree of the Taylor polynomial of e^X for clusters: exact to rounding error for |X| <= 1, as 1/19! < 1e-17.
CLUSTER_DEGREE = 18

#: 1-norm up to which the Pade approximant of e^X of degree 13 is exact to rounding error (Al-Mohy and Higham 2009); a larger X is
#: halved. That approximant takes about so many products of matrices.
PADE_NORM, EXPONENTIAL_PRODUCTS = 4.25, 9

#: Entries of e^X this small relative to the largest have products that are no normal numbers of float64.
NEGLIGIBLE_EXPONENTIAL = 1e-150

#: A product of a matrix and a vector takes so many times as long as its part of a product of matrices: it waits for memory.
NARROW_PRODUCT = 6.0

#: Exponents up to this keep e^x well within the range of float64.
MODERATE_EXPONENT = 690.0

#: P(s) is factored at this relative distance from an eigenvalue s, where it is regular.
FACTOR_DISTANCE = 1e-11

#: Error of the modal coordinates recovered from a sum of modes up to which all modes are there; those of states are refined once.
MODE_SUM_ERROR = 1e-9

#: Relative steps smaller than this that do not become smaller are rounding error.
STALLED_STEP = 1e-7

# Functions of time given by their values (``signals.approximated``).

#: Default tolerance: a little above the rounding error of polynomials of degree 10.
APPROXIMATION_TOLERANCE = 1e-12

#: Least tolerance: rounding errors of the values and of their polynomials stay below it.
LEAST_APPROXIMATION_TOLERANCE = 64 * EPS

#: Coefficients up to this many rounding errors of the largest value count as zero.
COEFFICIENT_NOISE = 16.0

#: A change of a coefficient at a joint up to this many times its error is no kink or jump.
JOINT_SAFETY = 4.0

#: The search for edges ends with intervals of this many units in the last place of the end.
EDGE_UNITS = 8

# Error estimates.

#: Every value of a small model is right to this part of the largest value at that time, a hundred times usual rounding errors.
PROVED_ACCURACY = 1e-12

#: Rows of combinations of derivatives, such as forces of stiff springs, that lose more than this part of their largest mode by rounding are proved.
CANCELLED_ROW = 1e-9

#: From this part of an extremum on, it is shown that a function may exceed it.
SHOWN_MARGIN = 1e-4

#: Models of up to so many states are small: the exact engine answers within a second.
PROVED_STATES = 48

#: A force that restarts more often is not summed exactly: each restart is a function of time of its own.
PROVED_RESTARTS = 32

#: Eigenvalues of a block nearer than this part of its size are separated by as much where its modes are needed.
EQUAL_EIGENVALUES = 1e-6

#: The error estimate compares the answer with answers to data perturbed by this many units in the last place.
PROBE_SIZE = 1.0

#: Rounded data do not decide whether a body is free or constrained by a stiffness of the size of rounding: in a time t that
#: makes a difference of eps (w t)^2, w the fastest frequency. Over thousands of periods that is a millionth: only more is reported.
ROUNDED_FREE = 1e-6

#: Least estimate of the relative error where a rank decision is not clear, since a wrong one invalidates all values.
UNCLEAR_ERROR = 0.1

#: An answer with a larger estimated relative error than this cannot be trusted (exit code 3).
TRUST_LIMIT = 1e-3

# Eigenvalues over a parameter (``polynomial.variation``).

#: Branches are connected where the predicted distance is at most this part of that of any other assignment.
CLEAR_ASSIGNMENT = 0.25

#: And where the product of the left vector of one end and the right vector of the other differs from 1 by no more than this.
SAME_BRANCH = 0.3

#: Intervals of a parameter are halved down to this part of its range: there, at a defective eigenvalue, branches have no names.
BRANCH_RESOLUTION = EPS**0.5

# Frequency responses.

#: A value with a larger estimated relative error is solved for again, with pivots of its own, and refined.
LINE_ACCURACY = 5e-11

#: Rounding errors of a form y^T A x of small matrices, in units of EPS and of its terms.
FORM_ROUNDING = 4.0

#: Entries of M, C and K are moved by so many units of EPS to see how far their rounding errors move a motion.
MOVED_DATA = 1.0

#: Extrema of a system of a family are located by its decoupled flow where that is this near to the flow, relative to its largest value: of
#: peaks that differ by less than twice as much either may be taken, their values are those of the flow.
LOCATED = 1e-11

#: Sums of modes are estimated to be wrong by this many times the largest difference from solutions at some lines.
SUM_SAFETY = 8.0

#: Zeros of an entry leave at most this part of its terms: eigenvalues are known to half of the digits where they are double.
ZERO_AGREEMENT = EPS**0.5

#: Lines are placed as for this damping ratio where a pole is nearer to the axis.
AUTO_DISTANCE = 1e-6

#: Powers of the largest frequency in the unit of time of the model: beyond, products leave the range of float64.
LARGEST_POWER = 1e150

#: Two frequencies, or times in a period, are the same within this relative distance: users write seven digits or more.
SAME_FREQUENCY = 1e-9

#: Rounding errors of the entries of A(i w) and of their residual, in units of EPS times their terms.
LINE_ROUNDING = 2.0

#: Poles with a smaller ratio of damping have real parts that are refined; below the other, a refined real part is rounding error.
LIGHT_DAMPING, UNDAMPED = 0.5, 1e10 * EPS**2

#: Integrals of spectra have smaller relative rounding errors than this, or their panels are halved, and values at their nodes solved for.
SPECTRAL_ACCURACY = 1e-13

#: Variances from stacked poles serve up to this estimated relative error, which adds the bounds of all modes: true errors are a hundredth.
STACKED_VARIANCE = 1e-9

#: Variances with larger estimated errors have a notice.
REPORTED_ERROR = 1e-9

#: Steps of a record, and numbers of a table, that agree to this are meant to be equal.
STEP_AGREEMENT = 1e-6


# Mechanical systems: matrices of elements, constraint rows, modes of sparse matrices.

#: Assembled in float64, springs or dampers with a larger ratio leave the softest fewer than four digits.
ASSEMBLED_SPREAD = 1e12

#: Springs or dampers with a larger ratio leave no digit of the softest even in precise arithmetic.
LARGEST_SPREAD = 1e40

#: Largest entry of X for which [-X; I] is the basis of a null space; beyond it (nearly dependent rows) an orthonormal one is better.
NULL_SPACE_LIMIT = 1e3

#: Sums of given entries that cancel up to this many units in the last place of their terms may be data as well as rounding errors of
#: the entries: two additions leave half a unit. They count from one unit on, and are reported.
DOUBTFUL_SUM = (0.5, 4.0)

#: Forces of a rigid body are this part of their terms, by rounding; those of an elastic chain of a million parts are more.
RIGID_BODY_FORCE = 64 * EPS

#: Sparse modes: frequencies closer than this, relative to the larger, are a group; modes are counted in larger gaps only.
FREQUENCY_GAP = EPS**0.5

#: Sparse modes: a vector has converged with a residual of this part of its value; the error of the value is the square of it.
RITZ_RESIDUAL = EPS**0.75

#: Signs of pivots count eigenvalues where the factors leave at most this part of a right side: a wrong sign needs an eigenvalue
#: that close to the shift, and then another shift is tried.
PIVOT_RESIDUAL = 1e-6

#: A sparse constraint row is solved for an entry of at least this part of its largest: entries of N grow at most tenfold a step.
PIVOT_RATIO = 0.1

#: The first shift of sparse modes, as a part of a typical K_ii / M_ii below zero: far above rounding for free bodies, and below the
#: lowest eigenvalues of all but the longest chains.
FIRST_SHIFT = 1e-9

#: Two damped modes of one eigenvalue with a larger cosine between their shapes are one mode.
SAME_SHAPE = 1 - EPS**0.5

#: Directions below this part of the others in the square of the energy norm are rounding errors.
DEPENDENT_DIRECTION = EPS**0.75

#: A Newton step below this part of the gap leaves a vector that is right to this times its square root.
NEWTON_STEP = EPS**0.5

#: Static corrections are refined to a residual of this part of the force.
CORRECTION_RESIDUAL = EPS**0.75

#: Free and forced motion of a mode are separated where the transformation times the largest rate is at most this many couplings.
RESONANCE_RATIO = 32.0

# Control: transfer functions and the mechanical normal form.

#: G(s) and gain prod(s - zeros)/prod(s - poles) agree to this, relatively; multiple zeros are known to few digits.
GAIN_AGREEMENT = 1e-6

#: Roots whose conjugates agree to this, relatively, are pairs: other packages print them with rounding errors.
CONJUGATE_ROOTS = 1e-10

#: Units of one model differ by at most twelve orders of magnitude: a coupling below this part of its row and column may be rounding
#: error in other units.
ROUNDED_COUPLING = 1e12 * EPS

#: From this many times its noise bound on a distance to non-existence counts, half-way in digits to a clear decision.
COUNTED_DISTANCE = CLEAR_KEPT**0.5

#: Eigenvalues of a compression with an imaginary part above this part of |A| are not the trace of a real one.
NEARLY_REAL = 1e-4

#: Above this part of |A| no refinement of an eigenvalue brings the distance near the noise.
FAR_FROM_EIGENVALUE = 1e-3

#: A transformation with a larger condition is singular: no digit of it is known.
SINGULAR_CONDITION = 1 / (1e3 * EPS)

#: Eigenvectors with a larger condition belong to a defective matrix: the square root of what rounding allows.
DEFECTIVE_CONDITION = 1 / (10 * EPS**0.5)

#: Eigenvalues of G closer than this part of |G| cannot be paired.
PAIRED_EIGENVALUES = 1e-6

#: An early value of a response is accurate when its error is at most this part of it.
EARLY_ERROR = 32 * EPS

# Robots at rest (``robot.equilibrium``); gaps are in rad or relative to the size of the robot.

#: A residual this small, relative to the largest force, is that of an equilibrium: Newton's method reaches 1e-13 where there
#: is one, and stays above 1e-3 where there is none.
BALANCED = 1e-9

#: Loops are closed below this gap: near a singular posture a gap hides a posture error of its square root.
LOOPS_CLOSED = 1e-12

#: Loops that the joints keep open by less are closed to the accuracy of a URDF with five digits.
LOOPS_CLOSED_AS_ROUNDED = 1e-5

#: Loops that stay open by less may do so because angles in the URDF have two digits: near a posture where rows become
#: dependent the gap is the square root of their error.
LOOPS_TILTED = 0.05

#: Rows of loops with a smaller relative singular value count as dependent: the axes of a URDF are often rounded to five or six
#: digits (1.5708), and loops that are planar to that accuracy are meant to be planar.
LOOP_RANK = 1e-5

#: Rows between LOOP_RANK and this are kept and reported as almost dependent.
LOOP_RANK_DOUBTFUL = 1e-4

#: Rows with a smaller relative singular value may be independent only because angles have two digits.
LOOP_RANK_TILTED = 5e-3

#: Rows below this are dependent to rounding error: loops are closed to LOOPS_CLOSED, and change their rows by as much. Those up to
#: LOOP_RANK may be so by the rounded digits of the URDF, which is reported.
LOOP_RANK_EXACT = 1e-12

#: Rounded data that make rows independent also keep the loop open, by a like amount; a gap below this part of it is none of theirs.
LEFT_OPEN = 1e-3

#: Second derivative along the motion, relative to that of single rows, above which a posture is singular (rounded axes: LOOP_RANK).
SINGULAR_POSTURE = 1e-4

#: A stiffness below this share of the largest is rounding error.
ZERO_STIFFNESS = 1e-13

#: Asymmetry of a stiffness matrix along the motion, relative to its largest entry, below which the load has a potential: the
#: residual of an equilibrium leaves 1e-12 there.
SYMMETRIC_STIFFNESS = 1e-9

#: A force at rest leaves the friction cone by more than this part of it: equilibria are right to 1e-9.
CONE_TOLERANCE = 1e-8

#: Tolerance of joint limits (rad, m): limits and guesses are written with six digits.
JOINT_LIMIT = 1e-6

#: Relative difference (rad, m for values below 1) below which two values of a locked mimic joint are equal.
SAME_JOINT_VALUE = 1e-9

# Sensitivities: multiple eigenvalues and derivatives of matrices (``polynomial.variation``, ``mechanics.sensitivities``).

#: Digits of determinants near multiple eigenvalues: circles of 10^-30 and powers up to the multiplicity cancel most of them.
SPLITTING_DIGITS = 400

#: Coefficients with fewer decimal places than this, relative to the leading one, are zero in that arithmetic.
EXACT_DIGITS = 90

#: The same where rounding errors of the data separate a multiple eigenvalue: what they leave of a coefficient that is zero.
SPLITTING_ROUNDING = 1e-10

#: Steps of central differences of order 8 relative to the parameter: truncation errors of smooth matrices are near 0.03^8, rounding
#: errors near EPS / 0.03.
DIFFERENCE_STEP = 0.03

#: Influences in per cent per per cent below this are shown as 0: rounding errors of what has none.
SHOWN_INFLUENCE = 1e-9

#: Imaginary steps relative to a number, whose squares vanish next to 1 without underflow.
COMPLEX_STEP = 1e-40

#: Steps of iterative refinement with residuals of long double: each gains the digits that the condition leaves.
REFINEMENT_STEPS = 3

#: A signal that differs from its hold between samples by less than this part of its largest value is its hold.
SAME_HOLD = 1e-9

# Scenes: consistent initial values and drawings (``scene``).

#: Motion, forces and impulses of a result below this share of the largest of their kind are rounding error, which is not drawn.
NOT_DRAWN = 1e-9

#: A singular value or a residual below this, relative to scaled constraint rows, is rounding error when consistent initial values
#: are computed: rows come from geometry known to 1e-12, and a mechanism this near to a dead centre counts as being in it.
CONSISTENT_ROWS = 1e-9

#: The size of a simplex in a box of unit size, and relative difference of values in it, at which an optimum is found: kinks, where two
#: peaks are equal, are found to this size, smooth minima to its square root.
SIMPLEX_SIZE = 1e-11

# Robots from MJCF files against MuJoCo.

#: Largest relative difference of masses and forces, which are computed by two algorithms through chains of joints.
SAME_AS_MUJOCO = 1e-9

#: The same of derivatives of MuJoCo's forces by differences of fourth order with steps of 0.2 mm and 0.2 mrad: tendons of a few
#: millimetres have large higher derivatives.
DIFFERENCED = 1e-6

#: Steps of these differences of coordinates (m, rad) and of rates (m/s, rad/s): of the force of a tendon of a centimetre neither truncation
#: nor rounding takes more than eight digits.
MUJOCO_STEP, MUJOCO_RATE = 2e-4, 1e-5

#: Axes of joints of which the cosine is larger are not at right angles.
RIGHT_ANGLE = 1e-9


# Largest values.

#: Values that exceed the best one by less than this part of it are not searched for.
EXTREMA_ACCURACY = 1e-12

#: Functions whose values differ from those of a more accurate method by more than this part of their RMS values are integrated by that.
ROUGH_PART = 1e-9

#: Parts of a function below this share of its largest amplitude do not decide how finely it is sampled.
VISIBLE_PART = 1e-6

#: Free vibrations have done their damage below this share of their first amplitude: with an exponent of 3 the rest is 1e-18 of it.
FREE_PART = 1e-6

# Periodic motions of switched systems.

#: A state has converged with a residual below this, relative to the range of each coordinate and velocity: unstable motions multiply
#: rounding errors by up to a million in a period.
CLOSED_ORBIT = 1e-9

#: Singular values of P' - I below this part of the largest belong to directions that nothing determines.
UNDETERMINED = 1e-10

#: A multiplier this near to 1 does not make a motion asymptotically stable.
STABILITY_MARGIN = 1e-9

#: Relative change of the frequency in differences: half of the digits.
FREQUENCY_DIFFERENCE = 1e-7

#: The shortest step along a branch, and the part of a step to which a change along it is located.
SHORTEST_STEP, LOCATED_CHANGE = 1e-6, 1e-9
