// fp32 operators for the cross-check of the cost model: round to nearest even, subnormal numbers taken and given as
// zero, infinities and NaN. Combinational; a unit puts registers between them.

module fp_add(input [31:0] a, input [31:0] b, output [31:0] y);
  wire swap = a[30:0] < b[30:0];
  wire [31:0] big = swap ? b : a;
  wire [31:0] little = swap ? a : b;
  wire [7:0] big_exponent = big[30:23];
  wire [7:0] little_exponent = little[30:23];
  // Significands with guard, round and sticky bits.
  wire [26:0] big_bits = big_exponent == 0 ? 27'd0 : {1'b1, big[22:0], 3'b000};
  wire [26:0] little_bits = little_exponent == 0 ? 27'd0 : {1'b1, little[22:0], 3'b000};
  wire [7:0] distance = big_exponent - little_exponent;
  wire [4:0] shift = distance > 8'd26 ? 5'd27 : distance[4:0];
  wire [53:0] aligned = {little_bits, 27'd0} >> shift;
  wire [26:0] addend = {aligned[53:28], aligned[27] | (|aligned[26:0])};
  wire subtract = a[31] ^ b[31];
  wire [27:0] sum = subtract ? {1'b0, big_bits} - {1'b0, addend} : {1'b0, big_bits} + {1'b0, addend};

  // Leading zeros of sum[26:0], then a shift by powers of two.
  wire [26:0] s0 = sum[26:0];
  wire z4 = s0[26:11] == 0;
  wire [26:0] s1 = z4 ? s0 << 16 : s0;
  wire z3 = s1[26:19] == 0;
  wire [26:0] s2 = z3 ? s1 << 8 : s1;
  wire z2 = s2[26:23] == 0;
  wire [26:0] s3 = z2 ? s2 << 4 : s2;
  wire z1 = s3[26:25] == 0;
  wire [26:0] s4 = z1 ? s3 << 2 : s3;
  wire z0 = ~s4[26];
  wire [26:0] s5 = z0 ? s4 << 1 : s4;
  wire [26:0] normal = sum[27] ? {sum[27:2], sum[1] | sum[0]} : s5;
  wire signed [9:0] exponent = sum[27] ? {2'b00, big_exponent} + 10'd1
                                       : {2'b00, big_exponent} - {5'd0, z4, z3, z2, z1, z0};
  wire round_up = normal[2] & (normal[1] | normal[0] | normal[3]);
  wire [24:0] rounded = {1'b0, normal[26:3]} + {24'd0, round_up};
  wire signed [9:0] final_exponent = exponent + {9'd0, rounded[24]};
  wire zero = sum == 0;
  wire sign = zero ? (a[31] & b[31]) : big[31];

  wire a_special = a[30:23] == 8'hff;
  wire b_special = b[30:23] == 8'hff;
  wire nan = (a_special & (|a[22:0])) | (b_special & (|b[22:0])) | (a_special & b_special & subtract);
  assign y = nan ? 32'h7fc00000
           : (a_special | b_special) ? {a_special ? a[31] : b[31], 8'hff, 23'd0}
           : (zero | final_exponent <= 0) ? {sign, 31'd0}
           : final_exponent >= 255 ? {sign, 8'hff, 23'd0}
           : {sign, final_exponent[7:0], rounded[24] ? rounded[23:1] : rounded[22:0]};
endmodule

module fp_sub(input [31:0] a, input [31:0] b, output [31:0] y);
  fp_add add(.a(a), .b({~b[31], b[30:0]}), .y(y));
endmodule

module fp_mul(input [31:0] a, input [31:0] b, output [31:0] y);
  wire sign = a[31] ^ b[31];
  wire a_zero = a[30:23] == 0;
  wire b_zero = b[30:23] == 0;
  wire [47:0] product = {1'b1, a[22:0]} * {1'b1, b[22:0]};
  wire [23:0] kept = product[47] ? product[47:24] : product[46:23];
  wire guard = product[47] ? product[23] : product[22];
  wire sticky = product[47] ? |product[22:0] : |product[21:0];
  wire [24:0] rounded = {1'b0, kept} + {24'd0, guard & (sticky | kept[0])};
  wire signed [9:0] exponent = {2'b00, a[30:23]} + {2'b00, b[30:23]} - 10'd127 + {9'd0, product[47]} + {9'd0, rounded[24]};
  wire a_special = a[30:23] == 8'hff;
  wire b_special = b[30:23] == 8'hff;
  wire nan = (a_special & (|a[22:0])) | (b_special & (|b[22:0])) | (a_special & b_zero) | (b_special & a_zero);
  assign y = nan ? 32'h7fc00000
           : (a_special | b_special) ? {sign, 8'hff, 23'd0}
           : (a_zero | b_zero | exponent <= 0) ? {sign, 31'd0}
           : exponent >= 255 ? {sign, 8'hff, 23'd0}
           : {sign, exponent[7:0], rounded[24] ? rounded[23:1] : rounded[22:0]};
endmodule

// a < b; false with NaN. -0 = +0. Subnormal numbers count.
module fp_less(input [31:0] a, input [31:0] b, output y);
  wire a_nan = a[30:23] == 8'hff && a[22:0] != 0;
  wire b_nan = b[30:23] == 8'hff && b[22:0] != 0;
  wire both_zero = a[30:0] == 0 && b[30:0] == 0;
  wire below = a[30:0] < b[30:0];
  wire above = a[30:0] > b[30:0];
  assign y = !a_nan & !b_nan & !both_zero &
             (a[31] ? (b[31] ? above : 1'b1) : (b[31] ? 1'b0 : below));
endmodule

// What the model calls fp_compare: a comparison and the choice that follows it.
module fp_min(input [31:0] a, input [31:0] b, output [31:0] y);
  wire less;
  fp_less compare(.a(a), .b(b), .y(less));
  assign y = less ? a : b;
endmodule

module fp_max(input [31:0] a, input [31:0] b, output [31:0] y);
  wire less;
  fp_less compare(.a(a), .b(b), .y(less));
  assign y = less ? b : a;
endmodule
