// SPDX-License-Identifier: Apache-2.0
// fp32 operators as functions, for inclusion inside a module: round to nearest even, no fused multiply-add, subnormal
// numbers as numbers, infinities and NaN (given as 7fc00000). Combinational; a unit puts registers between them.

// a + b.
function automatic logic [31:0] fp_add(input logic [31:0] a, input logic [31:0] b);
  /*verilator no_inline_task*/
  logic [31:0] big, little;
  logic [7:0]  big_exponent, little_exponent, distance, room;
  logic [26:0] big_bits, little_bits, addend, normal;  // significands with guard, round and sticky bits
  logic [53:0] aligned;
  logic [27:0] sum;
  logic [4:0]  zeros, shift;
  logic [26:0] s;
  logic [7:0]  exponent;
  logic [30:0] rounded;
  logic        subtract;
  big = a[30:0] < b[30:0] ? b : a;
  little = a[30:0] < b[30:0] ? a : b;
  big_exponent = big[30:23] == 8'd0 ? 8'd1 : big[30:23];
  little_exponent = little[30:23] == 8'd0 ? 8'd1 : little[30:23];
  big_bits = {big[30:23] != 8'd0, big[22:0], 3'b000};
  little_bits = {little[30:23] != 8'd0, little[22:0], 3'b000};
  distance = big_exponent - little_exponent;
  aligned = {little_bits, 27'd0} >> (distance > 8'd26 ? 5'd27 : distance[4:0]);
  addend = {aligned[53:28], aligned[27] | (|aligned[26:0])};
  subtract = a[31] ^ b[31];
  sum = subtract ? {1'b0, big_bits} - {1'b0, addend} : {1'b0, big_bits} + {1'b0, addend};
  // Leading zeros; of them as many are shifted out as the exponent allows.
  s = sum[26:0];
  zeros[4] = s[26:11] == 16'd0;
  s = zeros[4] ? s << 16 : s;
  zeros[3] = s[26:19] == 8'd0;
  s = zeros[3] ? s << 8 : s;
  zeros[2] = s[26:23] == 4'd0;
  s = zeros[2] ? s << 4 : s;
  zeros[1] = s[26:25] == 2'd0;
  s = zeros[1] ? s << 2 : s;
  zeros[0] = ~s[26];
  room = big_exponent - 8'd1;
  shift = room < {3'd0, zeros} ? room[4:0] : zeros;
  normal = sum[27] ? {sum[27:2], sum[1] | sum[0]} : sum[26:0] << shift;
  exponent = sum[27] ? big_exponent + 8'd1 : normal[26] ? big_exponent - {3'd0, shift} : 8'd0;
  // A carry out of the fraction goes into the exponent.
  rounded = {exponent, normal[25:3]} + {30'd0, normal[2] & (normal[1] | normal[0] | normal[3])};
  if ((a[30:23] == 8'hff && a[22:0] != 23'd0) || (b[30:23] == 8'hff && b[22:0] != 23'd0) ||
      (a[30:23] == 8'hff && b[30:23] == 8'hff && subtract)) begin
    fp_add = 32'h7fc00000;
  end else if (big[30:23] == 8'hff || exponent == 8'hff) begin
    fp_add = {big[31], 8'hff, 23'd0};
  end else if (sum == 28'd0) begin
    fp_add = {a[31] & b[31], 31'd0};
  end else begin
    fp_add = {big[31], rounded};
  end
endfunction

// a * b.
function automatic logic [31:0] fp_mul(input logic [31:0] a, input logic [31:0] b);
  /*verilator no_inline_task*/
  logic              sign;
  logic [23:0]       a_bits, b_bits, least;
  logic [4:0]        zeros, left;
  logic [47:0]       product, placed;
  logic [47:0]       lost;
  logic signed [9:0] exponent, right;  // of bit 46 of the product
  logic [7:0]        field;
  logic [30:0]       rounded;
  logic              guard, sticky, a_zero, b_zero;
  sign = a[31] ^ b[31];
  a_bits = {a[30:23] != 8'd0, a[22:0]};
  b_bits = {b[30:23] != 8'd0, b[22:0]};
  a_zero = a[30:0] == 31'd0;
  b_zero = b[30:0] == 31'd0;
  product = a_bits * b_bits;
  exponent = $signed({2'b00, a[30:23]}) + $signed({2'b00, b[30:23]}) - 10'sd127 +
             (a_bits[23] ? 10'sd0 : 10'sd1) + (b_bits[23] ? 10'sd0 : 10'sd1);
  // Leading zeros of the one operand that is subnormal; if both are, the product is less than half the least number.
  least = a_bits[23] ? b_bits : a_bits;
  zeros[4] = least[23:8] == 16'd0;
  least = zeros[4] ? least << 16 : least;
  zeros[3] = least[23:16] == 8'd0;
  least = zeros[3] ? least << 8 : least;
  zeros[2] = least[23:20] == 4'd0;
  least = zeros[2] ? least << 4 : least;
  zeros[1] = least[23:22] == 2'd0;
  least = zeros[1] ? least << 2 : least;
  zeros[0] = ~least[23];
  // To the left until it is normal or its exponent the least, or to the right until its exponent is the least.
  right = 10'sd1 - exponent;
  left = exponent > $signed({5'd0, zeros}) ? zeros : exponent > 10'sd0 ? exponent[4:0] - 5'd1 : 5'd0;
  lost = 48'd0;
  if (exponent > 10'sd0) begin
    placed = product << left;
    exponent = exponent - $signed({5'd0, left});
  end else begin
    placed = right > 10'sd47 ? 48'd0 : product >> right[5:0];
    lost = right > 10'sd47 ? product : product & ~(48'hffffffffffff << right[5:0]);
    exponent = 10'sd1;
  end
  field = placed[47] ? exponent[7:0] + 8'd1 : placed[46] ? exponent[7:0] : 8'd0;
  guard = placed[47] ? placed[23] : placed[22];
  sticky = (placed[47] & placed[22]) | (|placed[21:0]) | (|lost);
  rounded = {field, placed[47] ? placed[46:24] : placed[45:23]} +
            {30'd0, guard & (sticky | (placed[47] ? placed[24] : placed[23]))};
  if ((a[30:23] == 8'hff && a[22:0] != 23'd0) || (b[30:23] == 8'hff && b[22:0] != 23'd0) ||
      (a[30:23] == 8'hff && b_zero) || (b[30:23] == 8'hff && a_zero)) begin
    fp_mul = 32'h7fc00000;
  end else if (a[30:23] == 8'hff || b[30:23] == 8'hff || exponent > 10'sd254 || (placed[47] && exponent == 10'sd254)) begin
    fp_mul = {sign, 8'hff, 23'd0};
  end else begin
    fp_mul = {sign, rounded};
  end
endfunction

// a < b; false with NaN; -0 = +0.
function automatic logic fp_less(input logic [31:0] a, input logic [31:0] b);
  /*verilator no_inline_task*/
  logic nan, zeros, below, above;
  nan = (a[30:23] == 8'hff && a[22:0] != 23'd0) || (b[30:23] == 8'hff && b[22:0] != 23'd0);
  zeros = a[30:0] == 31'd0 && b[30:0] == 31'd0;
  below = a[30:0] < b[30:0];
  above = a[30:0] > b[30:0];
  fp_less = ~nan & ~zeros & (a[31] ? (b[31] ? above : 1'b1) : (b[31] ? 1'b0 : below));
endfunction

// a <= b; false with NaN.
function automatic logic fp_less_equal(input logic [31:0] a, input logic [31:0] b);
  /*verilator no_inline_task*/
  logic nan;
  nan = (a[30:23] == 8'hff && a[22:0] != 23'd0) || (b[30:23] == 8'hff && b[22:0] != 23'd0);
  fp_less_equal = ~nan & ~fp_less(b, a);
endfunction

// 1 / d in three parts, each a row of eight steps of long division; what must not meet an infinite difference as zero or
// infinity, 1 / 0 and all that overflows, is the largest number with the sign of d. State: remainder, quotient.
localparam FP_DIVISION = 25 + 24;

// Significand of d with its leading one; of subnormal numbers only those count whose reciprocal is a number.
function automatic logic [23:0] fp_significand(input logic [31:0] d);
  fp_significand = d[30:23] != 8'd0 ? {1'b1, d[22:0]} : d[22] ? {d[22:0], 1'b0} : {d[21:0], 2'b00};
endfunction

function automatic logic [FP_DIVISION-1:0] fp_divide(input logic [31:0] d, input logic [FP_DIVISION-1:0] from);
  /*verilator no_inline_task*/
  logic [24:0] rest, less;
  logic [23:0] quotient, significand;
  significand = fp_significand(d);
  {rest, quotient} = from;
  for (int i = 0; i < 8; i = i + 1) begin
    rest = {rest[23:0], 1'b0};
    less = rest - {1'b0, significand};
    quotient = {quotient[22:0], rest >= {1'b0, significand}};
    rest = rest >= {1'b0, significand} ? less : rest;
  end
  fp_divide = {rest, quotient};
endfunction

// The first step of the division leaves 2^24 - significand.
function automatic logic [FP_DIVISION-1:0] fp_divide_begin(input logic [31:0] d);
  /*verilator no_inline_task*/
  fp_divide_begin = fp_divide(d, {25'd16777216 - {1'b0, fp_significand(d)}, 24'd0});
endfunction

function automatic logic [31:0] fp_reciprocal(input logic [31:0] d, input logic [FP_DIVISION-1:0] from);
  /*verilator no_inline_task*/
  logic [24:0]       rest, q;
  logic [23:0]       quotient;
  logic signed [9:0] exponent;
  logic [30:0]       rounded;
  logic              power;
  {rest, quotient} = fp_divide(d, from);
  q = {1'b1, quotient};
  power = fp_significand(d) == 24'h800000;
  exponent = 10'sd253 - $signed({2'b00, d[30:23]}) + (power ? 10'sd1 : 10'sd0);
  if (d[30:23] == 8'd0) exponent = exponent - (d[22] ? 10'sd0 : -10'sd1);
  if (power) begin
    rounded = exponent > 10'sd0 ? {exponent[7:0], 23'd0} : {8'd0, 1'b1, 22'd0};
  end else if (exponent > 10'sd0) begin
    rounded = {exponent[7:0], q[23:1]} + {30'd0, q[0] & (rest != 25'd0 | q[1])};
  end else if (exponent == 10'sd0) begin
    rounded = {8'd0, q[24:2]} + {30'd0, q[1] & (q[0] | rest != 25'd0 | q[2])};
  end else begin
    rounded = {9'd0, q[24:3]} + {30'd0, q[2] & (q[1] | q[0] | rest != 25'd0 | q[3])};
  end
  if (d[30:23] == 8'hff) begin
    fp_reciprocal = {d[31], d[22:0] == 23'd0 ? 31'd0 : 31'h7f7fffff};
  end else if (d[30:23] == 8'd0 && d[22:0] <= 23'h200000) begin
    fp_reciprocal = {d[31], 31'h7f7fffff};
  end else begin
    fp_reciprocal = {d[31], rounded};
  end
endfunction
