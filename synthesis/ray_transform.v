// Origin and direction through a 3 x 4 matrix, as modules/rt_unit/intersection_unit.cpp counts it without its reciprocals: 18 mul,
// 15 add, a register after each operator. A ray a clock, three stages.
module ray_transform(input clk, input [287:0] matrix, input [95:0] translation, input [95:0] origin,
                     input [95:0] direction, output reg [95:0] o, output reg [95:0] d);
  reg [287:0] o_1, d_1;
  reg [95:0] t_1, o_a_2, o_b_2, d_a_2, d_b_2;
  wire [287:0] o_m, d_m;
  wire [95:0] o_a, o_b, d_a, o_c, d_c;
  genvar r, c;
  generate
    for (r = 0; r < 3; r = r + 1) begin : row
      for (c = 0; c < 3; c = c + 1) begin : column
        fp_mul of_origin(.a(matrix[32 * (3 * r + c) +: 32]), .b(origin[32 * c +: 32]), .y(o_m[32 * (3 * r + c) +: 32]));
        fp_mul of_direction(.a(matrix[32 * (3 * r + c) +: 32]), .b(direction[32 * c +: 32]), .y(d_m[32 * (3 * r + c) +: 32]));
      end
      fp_add o_xy(.a(o_1[96 * r +: 32]), .b(o_1[96 * r + 32 +: 32]), .y(o_a[32 * r +: 32]));
      fp_add o_zt(.a(o_1[96 * r + 64 +: 32]), .b(t_1[32 * r +: 32]), .y(o_b[32 * r +: 32]));
      fp_add d_xy(.a(d_1[96 * r +: 32]), .b(d_1[96 * r + 32 +: 32]), .y(d_a[32 * r +: 32]));
      fp_add o_sum(.a(o_a_2[32 * r +: 32]), .b(o_b_2[32 * r +: 32]), .y(o_c[32 * r +: 32]));
      fp_add d_sum(.a(d_a_2[32 * r +: 32]), .b(d_b_2[32 * r +: 32]), .y(d_c[32 * r +: 32]));
    end
  endgenerate
  always @(posedge clk) begin
    o_1 <= o_m; d_1 <= d_m; t_1 <= translation;
    o_a_2 <= o_a; o_b_2 <= o_b; d_a_2 <= d_a; d_b_2 <= {d_1[287:256], d_1[191:160], d_1[95:64]};
    o <= o_c; d <= d_c;
  end
endmodule
