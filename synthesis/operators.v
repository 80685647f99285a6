// All operators side by side, for the check of their arithmetic.
module operators(input [31:0] a, input [31:0] b, output [31:0] sum, output [31:0] difference, output [31:0] product,
                 output less, output [31:0] least, output [31:0] most);
  fp_add add(.a(a), .b(b), .y(sum));
  fp_sub subtract(.a(a), .b(b), .y(difference));
  fp_mul multiply(.a(a), .b(b), .y(product));
  fp_less compare(.a(a), .b(b), .y(less));
  fp_min minimum(.a(a), .b(b), .y(least));
  fp_max maximum(.a(a), .b(b), .y(most));
endmodule
